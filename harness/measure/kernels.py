"""What a kernel is made of: read from the compiler's log and from the compiled program.

Needs NVRTC and no GPU.
"""

import struct
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from harness.measure.files import hash_files, key_of, read_json, write_json

ENTRY = "haste_kernel"
INSTRUCTION_BYTES = 16
"""Of every architecture since Volta (NVIDIA, CUDA Binary Utilities, Instruction Set Reference)."""
BLOCK = 128
"""Threads of a block: the engines' default."""

WARPS_AND_BLOCKS = {
    75: (32, 16),
    80: (64, 32),
    86: (48, 16),
    87: (48, 16),
    89: (48, 24),
    90: (64, 32),
    100: (64, 32),
    103: (64, 32),
    120: (48, 24),
    121: (48, 24),
}
"""Most warps and blocks that a multiprocessor holds, by architecture (CUDA C++ Programming Guide,
Technical Specifications per Compute Capability)."""
REGISTERS = 65536
"""Of a multiprocessor, the same in all of them, in four parts that each hold whole warps."""
PARTS = 4
REGISTER_UNIT = 256
"""Registers are given to a warp in such units."""
WARP = 32


@dataclass(frozen=True, slots=True)
class Program:
    """A kernel with all that decides what it compiles to."""

    kernel: str
    model: str
    precision: str
    features: int
    stack: int
    traversal: str
    architecture: int

    def compile(self) -> dict[str, Any]:
        """Compile it, whatever is in the cache; raises CompileError."""
        from haste_cuda import _core

        found: dict[str, Any] = _core.compile_kernel(
            *(self.kernel, self.model, self.precision, self.features, self.stack),
            traversal=self.traversal,
            architecture=self.architecture,
            use_cache=False,
        )
        return found


@dataclass(frozen=True, slots=True)
class KernelCost:
    """What one kernel takes.

    occupancy: warps that a multiprocessor holds of those that it could, by registers, in blocks of
    `BLOCK` threads; None of an architecture whose limits are not known. compile_seconds: time in
    NVRTC of each compilation, [s].
    """

    registers: int
    spill_bytes: int
    instructions: int
    occupancy: float | None
    compile_seconds: tuple[float, ...]


def occupancy(registers: int, architecture: int, block: int = BLOCK) -> float | None:
    """Share of a multiprocessor's warps that its registers allow; None where that is not known.

    Parameters
    ----------
    registers
        Of a thread.
    architecture
        10 major + minor of the compute capability.
    block
        Threads of a block.
    """
    limits = WARPS_AND_BLOCKS.get(architecture)
    if limits is None:
        return None
    most_warps, most_blocks = limits
    of_warp = -(-registers * WARP // REGISTER_UNIT) * REGISTER_UNIT
    warps = PARTS * (REGISTERS // PARTS // of_warp)
    warps_of_block = -(-block // WARP)
    blocks = min(warps // warps_of_block, most_warps // warps_of_block, most_blocks)
    return blocks * warps_of_block / most_warps


def count_instructions(cubin: bytes, entry: str = ENTRY) -> int:
    """Instructions of a kernel, the compiler's filling at its end included.

    Raises
    ------
    ValueError
        The program is no 64-bit ELF file, or has no such kernel.
    """
    if cubin[:6] != b"\x7fELF\x02\x01":
        raise ValueError("a cubin is a 64-bit ELF file of the little endian")
    (table,) = struct.unpack_from("<Q", cubin, 0x28)
    width, count, names_at = struct.unpack_from("<HHH", cubin, 0x3A)
    sections = [struct.unpack_from("<IIQQQQ", cubin, table + width * i) for i in range(count)]
    names = sections[names_at][4]
    wanted = f".text.{entry}".encode() + b"\0"
    for name, _, _, _, _, size in sections:
        if cubin.startswith(wanted, names + name):
            return int(size) // INSTRUCTION_BYTES
    raise ValueError(f"the cubin has no kernel {entry}")


def measure_kernel(program: Program, repeats: int, shelf: Path) -> KernelCost:
    """Compile a kernel so many times, or find on the shelf what an equal one took.

    Parameters
    ----------
    shelf
        Folder of files, one a kernel: scenes that require the same share them.

    Raises
    ------
    haste_cuda.CompileError
        There is no NVRTC, or the kernel does not compile.
    """
    from haste_cuda import _core

    headers = Path(_core.__file__).parent
    code = hash_files([*headers.rglob("core/**/*.h"), *headers.rglob("cuda/kernels/*")])
    version = _core.nvrtc_version()
    key = key_of({**asdict(program), "code": code, "nvrtc": version, "repeats": repeats})
    path = shelf / f"{key}.json"
    known = read_json(path)
    if isinstance(known, dict):
        return KernelCost(**{**known, "compile_seconds": tuple(known["compile_seconds"])})
    built = [program.compile() for _ in range(repeats)]
    resources = built[0]["kernels"][ENTRY]
    cost = KernelCost(
        registers=int(resources["registers"]),
        spill_bytes=int(resources["spill_store_bytes"] + resources["spill_load_bytes"]),
        instructions=count_instructions(built[0]["cubin"]),
        occupancy=occupancy(int(resources["registers"]), program.architecture),
        compile_seconds=tuple(float(one["compile_seconds"]) for one in built),
    )
    shelf.mkdir(parents=True, exist_ok=True)
    write_json(path, asdict(cost))
    return cost
