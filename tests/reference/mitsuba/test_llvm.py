from __future__ import annotations

from pathlib import Path

import pytest

from reference.mitsuba.llvm import choose, installed_libraries, library_version


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM-15.so.1", 15),
        ("libLLVM-14.0.6.so.1", 14),
        ("libLLVM-16.so", 16),
        ("libLLVM.so.19.1", 19),
        ("libLLVM.so.18", 18),
        ("libLLVM.20.1.dylib", 20),
        ("libLLVM.so", None),
        ("libLLVM.so.1", None),
        ("libLLVMCore.a", None),
    ],
)
def test_version_is_read_from_every_distributions_file_name(name: str, version: int | None):
    assert library_version(Path("/nowhere") / name) == version


def test_version_of_an_unversioned_link_is_that_of_its_target(tmp_path: Path):
    (tmp_path / "libLLVM.so.19.1").touch()
    (tmp_path / "libLLVM.so").symlink_to("libLLVM.so.19.1")
    assert library_version(tmp_path / "libLLVM.so") == 19


def test_static_archives_and_dangling_links_are_no_libraries(tmp_path: Path):
    (tmp_path / "libLLVMCore.a").touch()
    (tmp_path / "libLLVM-17.so.1").symlink_to("gone")
    (tmp_path / "libLLVM-18.so.1").touch()
    assert installed_libraries((f"{tmp_path}/libLLVM*",)) == {18: tmp_path / "libLLVM-18.so.1"}


@pytest.mark.parametrize(
    ("versions", "expected"),
    [((14, 15, 19), 19), ((16, 18), 18), ((15, 21, 23), 21), ((17, 22), 17)],
)
def test_versions_known_to_work_come_before_newer_ones(versions: tuple[int, ...], expected: int):
    choice = choose(None, {version: Path(f"libLLVM-{version}.so") for version in versions})
    assert (choice.version, choice.reason) == (expected, None), choice


@pytest.mark.parametrize("versions", [(), (14, 15)])
def test_without_a_usable_library_the_reason_names_the_package(versions: tuple[int, ...]):
    choice = choose(None, {version: Path(f"libLLVM-{version}.so") for version in versions})
    assert choice.path is None
    assert choice.reason is not None and "apt-get install libllvm19" in choice.reason


def test_a_requested_library_that_would_abort_the_process_is_refused(tmp_path: Path):
    old = tmp_path / "libLLVM-15.so.1"
    old.touch()
    choice = choose(str(old), {19: Path("libLLVM.so.19.1")})
    assert choice.path is None
    assert choice.reason is not None and "LLVM 15" in choice.reason, choice


def test_a_requested_library_that_is_missing_is_named():
    choice = choose("/nowhere/libLLVM-19.so", {})
    assert choice.reason is not None and "/nowhere/libLLVM-19.so" in choice.reason, choice


def test_a_requested_usable_library_wins(tmp_path: Path):
    wanted = tmp_path / "libLLVM-17.so.1"
    wanted.touch()
    assert choose(str(wanted), {19: Path("libLLVM.so.19.1")}).path == str(wanted)
