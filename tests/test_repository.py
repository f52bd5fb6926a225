"""What the repository promises about its own files."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml

REPOSITORY = Path(__file__).resolve().parents[1]
CORE = REPOSITORY / "haste_cuda" / "core"
CORE_HEADERS = sorted(CORE.rglob("*.h"))
SCENES = sorted(path.parent for path in (REPOSITORY / "scenes").rglob("scene.xml"))
DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md")])

# 1e-4f, 0.001, 0x1p-20: a length, an angle or a weight that somebody thought small.
SMALL_LITERAL = re.compile(r"\b\d+\.?\d*[eE]-\d+|\b0?\.00\d*|\b0[xX][\da-fA-F.]+[pP]-\d+")
# The step of 24 random bits is a unit, a plane's margin is in steps of its grid, and the lower part
# of ln 2 is a number: no tolerances.
UNITS = {
    ("sampling/random.h", "0x1p-24"),
    ("base/bvh8.h", "0x1p-7"),
    ("math/elementary.h", "2.12194440054690582768e-4"),
    ("math/elementary.h", "1.42860682030941723212e-6"),
}


def without_comments(source: str) -> str:
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", source, flags=re.DOTALL)


def small_literals(source: str) -> list[str]:
    return SMALL_LITERAL.findall(without_comments(source))


def test_the_snakefile_is_at_most_forty_lines() -> None:
    lines = (REPOSITORY / "Snakefile").read_text().splitlines()
    assert len(lines) <= 40


def test_the_core_is_found() -> None:
    assert len(CORE_HEADERS) > 20, CORE_HEADERS


@pytest.mark.parametrize("header", CORE_HEADERS, ids=lambda path: str(path.relative_to(CORE)))
def test_no_core_header_holds_an_absolute_epsilon(header: Path) -> None:
    name = str(header.relative_to(CORE))
    if name == "math/numeric.h":
        return
    found = [
        literal for literal in small_literals(header.read_text()) if (name, literal) not in UNITS
    ]
    assert not found, f"{name} holds {found}; scale-free bounds are in core/math/numeric.h"


@pytest.mark.parametrize("planted", ["t_min = 1e-4f;", "x < 0.001", "0x1p-20f", "if (d < 5.0E-3)"])
def test_a_planted_epsilon_is_found(planted: str) -> None:
    assert small_literals(planted)


@pytest.mark.parametrize("innocent", ["0.5f", "1.0 / 3.0", "// 1e-4 of a pixel", "0.05"])
def test_an_ordinary_constant_is_no_epsilon(innocent: str) -> None:
    assert not small_literals(innocent)


def test_only_the_platform_header_includes_standard_headers() -> None:
    found = [
        f"{header.relative_to(CORE)}: {line}"
        for header in CORE_HEADERS
        if header.name != "config.h"
        for line in header.read_text().splitlines()
        if re.match(r"\s*#\s*include\s*<", line)
    ]
    assert not found, found


def test_only_the_platform_header_has_macros() -> None:
    found = [
        f"{header.relative_to(CORE)}: {line}"
        for header in CORE_HEADERS
        if header.name != "config.h"
        for line in header.read_text().splitlines()
        if re.match(r"\s*#\s*(define|undef|if|ifdef|ifndef|else|elif|endif)\b", line)
    ]
    assert not found, found


def test_the_core_knows_neither_cuda_nor_embree() -> None:
    words = re.compile(r"\b(__global__|threadIdx|blockIdx|cuda[A-Z]\w*|CU[a-z]\w*|rtc[A-Z]\w*)\b")
    found = [
        f"{header.relative_to(CORE)}: {match.group()}"
        for header in CORE_HEADERS
        for match in words.finditer(without_comments(header.read_text()))
    ]
    assert not found, found


@pytest.mark.parametrize("scene", SCENES, ids=lambda path: str(path.relative_to(REPOSITORY)))
def test_every_scene_has_a_readme_and_settings(scene: Path) -> None:
    for name in ("README.md", "settings.yaml"):
        assert (scene / name).is_file(), f"{scene.relative_to(REPOSITORY)} has no {name}"
    assert yaml.safe_load((scene / "settings.yaml").read_text()), "the settings are empty"


def test_the_five_scenes_are_there() -> None:
    names = {scene.name for scene in SCENES}
    assert {"cornell-box", "three-spheres", "skull", "mirror-glass", "hard"} <= names


def commands_of_bench() -> set[str]:
    result = subprocess.run(
        [str(REPOSITORY / "bench"), "help"], capture_output=True, text=True, check=True
    )
    return set(re.findall(r"^  ([a-z]+) ", result.stdout, flags=re.MULTILINE))


def test_the_readme_shows_the_two_commands() -> None:
    readme = (REPOSITORY / "README.md").read_text()
    for command in ("./bench all", "./bench test"):
        assert command in readme


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_command_that_a_document_names_exists(document: Path) -> None:
    named = set(re.findall(r"\./bench ([a-z]+)", document.read_text()))
    assert named <= commands_of_bench(), f"{document.name} names commands that do not exist"


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_link_of_a_document_leads_somewhere(document: Path) -> None:
    targets = re.findall(r"\]\(([^)#]+)", document.read_text())
    local = [target for target in targets if not re.match(r"[a-z]+:", target)]
    missing = [target for target in local if not (document.parent / target).exists()]
    assert not missing, f"{document.name} links to {missing}"


def test_every_file_that_the_architecture_names_exists() -> None:
    text = (REPOSITORY / "docs" / "architecture.md").read_text()
    named = set(re.findall(r"`([\w.-]+(?:/[\w.-]+)*/?)`", text))
    paths = {name for name in named if "/" in name or re.search(r"\.(py|h|cpp|md|yaml|smk)$", name)}
    produced = {name for name in paths if name.startswith("results/")}
    missing = sorted(name for name in paths - produced if not (REPOSITORY / name).exists())
    assert len(paths) > 15, f"only {len(paths)} files are named"
    assert not missing, missing


def test_the_architecture_fits_a_page() -> None:
    text = (REPOSITORY / "docs" / "architecture.md").read_text()
    assert len(text.splitlines()) <= 90


def test_every_direct_requirement_is_locked_with_hashes() -> None:
    for stem in ("requirements", "requirements-cu12"):
        lock = (REPOSITORY / f"{stem}.lock").read_text()
        locked = set(re.findall(r"^([\w.-]+)==", lock, flags=re.MULTILINE))
        direct = re.findall(r"^([\w.-]+)", (REPOSITORY / f"{stem}.in").read_text(), re.MULTILINE)
        missing = [name for name in direct if name.lower().replace("_", "-") not in locked]
        assert not missing, f"{stem}.lock lacks {missing}"
        without_hash = re.findall(r"^[\w.-]+==[^\\\n]*\n", lock, flags=re.MULTILINE)
        assert not without_hash, without_hash


def test_every_statement_of_the_version_agrees() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text())
    cmake = (REPOSITORY / "CMakeLists.txt").read_text()
    assert citation["version"] == project["version"]
    assert f"project(haste VERSION {project['version']} " in cmake
    assert f"## {project['version']}" in (REPOSITORY / "CHANGELOG.md").read_text()
