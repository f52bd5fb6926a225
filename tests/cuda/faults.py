"""What is wrong with a compiled kernel, as the tests of every kind of kernel ask."""

from __future__ import annotations

from typing import Any

THREADS = 256
"""of a block"""
REGISTERS = 65536
"""of a multiprocessor"""


def faults(result: dict[str, Any], *, kernel: str = "haste_kernel", blocks: int = 0) -> list[str]:
    """Spills of a compiled kernel, warnings, and registers that keep blocks out; a line each.

    Parameters
    ----------
    result
        What the compiler has answered.
    kernel
        The kernel's name.
    blocks
        So many blocks of THREADS must have registers at a time.
    """
    found = result["kernels"][kernel]
    lines = [
        f"{found[spill]} {spill}"
        for spill in ("spill_store_bytes", "spill_load_bytes")
        if found[spill] != 0
    ]
    if blocks * THREADS * found["registers"] > REGISTERS:
        lines.append(f"{found['registers']} registers: fewer than {blocks} blocks")
    return lines + [line for line in result["log"].splitlines() if not line.startswith("ptxas")]
