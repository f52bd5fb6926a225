"""What the tests of the CUDA layer share: the extension, made ready, with a cache of its own."""

from pathlib import Path
from types import ModuleType

import pytest

from haste_cuda import _core, nvrtc


@pytest.fixture(scope="session")
def core() -> ModuleType:
    """The extension with NVRTC and the kernels' headers configured. No GPU is needed."""
    nvrtc.configure()
    return _core


@pytest.fixture
def compiler(core: ModuleType) -> ModuleType:
    """The same where NVRTC works; the test is skipped with the reason where it does not."""
    reason = core.nvrtc_unavailable()
    if reason is not None:
        pytest.skip(reason)
    return core


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty kernel cache for one test; the folder that will hold the files."""
    monkeypatch.setenv("HASTE_CACHE", str(tmp_path))
    return tmp_path / "cubin"
