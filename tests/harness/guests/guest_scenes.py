"""Small scenes as text, and the ones by others that come from the package index."""

from __future__ import annotations

import hashlib
import re
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
WHEEL = ROOT / "build" / "guests" / "sionna_rt-2.2.0-py3-none-any.whl"
WHEEL_SHA256 = "ffd5b5fea0fd3fee9d64a9e2b0ff1f2f4b4bfc010fa3d59d7479955fbdfc0e8e"
DOWNLOAD_SECONDS = 120

LAMP = '<shape type="sphere" id="lamp"><emitter type="area"/></shape>'
PLY = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
)
CORNERS = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)


def face(*indices: int) -> bytes:
    """One record of a PLY file's faces."""
    return struct.pack(f"<B{len(indices)}i", len(indices), *indices)


def sensor(width: int = 8, height: int = 8, film: str = "hdrfilm") -> str:
    """A camera at (0, 0, 5) that looks at the origin; one line."""
    sides = "".join(
        f'<integer name="{name}" value="{value}"/>'
        for name, value in (("width", width), ("height", height))
    )
    return (
        '<sensor type="perspective" id="eye"><transform name="to_world">'
        '<lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>'
        f'<film type="{film}" id="plane">{sides}</film></sensor>'
    )


def write(folder: Path, body: str, camera: str | None = None, name: str = "scene.xml") -> Path:
    """Write a scene: line 1 opens it, the body begins on line 2, the camera has the line after."""
    file = folder / name
    camera = sensor() if camera is None else camera
    file.write_text(f'<scene version="3.0.0">\n{body}\n{camera}\n</scene>\n')
    return file


def sionna_wheel() -> Path:
    """The wheel of sionna-rt 2.2.0, downloaded once; skips where the index is out of reach."""
    if not WHEEL.is_file():
        command = [sys.executable, "-m", "pip", "download", "--disable-pip-version-check"]
        command += ["--no-deps", "--quiet", "--dest", str(WHEEL.parent), "sionna-rt==2.2.0"]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, timeout=DOWNLOAD_SECONDS
            )
            reason = done.stderr.strip().splitlines()[-1:] if done.returncode else []
        except subprocess.TimeoutExpired:
            reason = [f"no answer within {DOWNLOAD_SECONDS} s"]
        if reason:
            pytest.skip(f"sionna-rt cannot be downloaded: {reason[0]}")
    found = hashlib.sha256(WHEEL.read_bytes()).hexdigest()
    assert found == WHEEL_SHA256, f"{WHEEL} is another file than the one tested with: {found}"
    return WHEEL


def unpack(wheel: Path, scene: str, folder: Path) -> Path:
    """Unpack one of sionna-rt's scenes; returns its Mitsuba file."""
    inside = f"sionna/rt/scenes/{scene}/"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if inside in name])
    return folder / inside / f"{scene}.xml"


def scanned_types(file: Path) -> list[tuple[str, str]]:
    """(tag, type) of each element with a type, by a scan of the text that knows nothing of XML."""
    text = re.sub(r"<!--.*?-->", "", file.read_text(), flags=re.DOTALL)
    return re.findall(r'<(\w+)\b[^<>]*\btype\s*=\s*"([^"]*)"', text)
