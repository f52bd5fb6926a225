"""The commands of `./bench`, on copies of it with stand-ins for pip, apt-get and sudo."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
PYTEST = "python -m pytest --numprocesses=auto --dist=loadfile"
"""What `bench test` runs."""
TOOLS = """
    bash cat cp dirname env find mkdir pwd realpath rm sed sha256sum sort tail touch true xargs
"""

PYTHON = """#!/usr/bin/env bash
# Stands in for an interpreter: notes what it is asked, makes "virtual environments" of itself.
case "$1 $2" in
    "-m venv") mkdir -p "$3/bin" && cp "$0" "$3/bin/python" ;;
    "-m pip") [[ ! -e $STATE/no-network ]] ;;
    "-c import sys"*) [[ ! -e $STATE/python-is-old ]] ;;
esac
status=$?
[[ $1 == -m ]] && echo "python $*" >>"$STATE/calls"
exit $status
"""

APT_GET = """#!/usr/bin/env bash
# Stands in for apt-get: installing git puts one on PATH, unless the package lists are missing.
echo "apt-get $*" >>"$STATE/calls"
[[ ! -e $STATE/apt-is-broken ]] || exit 100
case $1 in
    update) rm -f "$STATE/no-lists" ;;
    install) [[ ! -e $STATE/no-lists ]] && cp --remove-destination "$STATE/bin/"{true,git} ;;
esac
"""

SUDO = """#!/usr/bin/env bash
[[ ! -e $STATE/sudo-is-refused ]] || exit 1
[[ $1 == -n ]] && shift
exec "$@"
"""


@dataclass(frozen=True)
class Checkout:
    """A copy of `bench` in a folder whose name has spaces, on a machine made of stand-ins."""

    root: Path
    state: Path

    def run(
        self, *arguments: str, user: str | None = None, folder: Path | None = None
    ) -> subprocess.CompletedProcess[str]:
        environment = {
            "PATH": str(self.state / "bin"),
            "STATE": str(self.state),
            "DRJIT_LIBLLVM_PATH": str(self.state / "libLLVM-19.so"),
        }
        return subprocess.run(
            [str(self.root / "bench"), *arguments],
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
            user=user,
            cwd=folder,
        )

    def calls(self) -> list[str]:
        """The calls of stand-ins since the last time."""
        notes = self.state / "calls"
        lines = notes.read_text().splitlines() if notes.exists() else []
        notes.unlink(missing_ok=True)
        return lines

    def arrange(self, *facts: str) -> None:
        for fact in facts:
            (self.state / fact).touch()


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    root = tmp_path / "a path with spaces" / "haste"
    state = tmp_path / "state"
    (state / "bin").mkdir(parents=True)
    (state / "libLLVM-19.so").touch()
    for tool in TOOLS.split():
        found = shutil.which(tool)
        assert found, f"{tool} is not on PATH"
        (state / "bin" / tool).symlink_to(found)
    for name in ("c++", "git", "sbatch", "chromium"):
        (state / "bin" / name).symlink_to(state / "bin" / "true")
    for name, text in {"python3": PYTHON, "apt-get": APT_GET, "sudo": SUDO}.items():
        script = state / "bin" / name
        script.write_text(text)
        script.chmod(0o755)

    (root / "haste_cuda" / "core").mkdir(parents=True)
    (root / "reference" / "embree").mkdir(parents=True)
    (root / "haste_cuda" / "core" / "config.h").write_text("// one\n")
    (root / "haste_cuda" / "__init__.py").touch()
    for name in ("bench", "requirements.lock", "requirements-cu12.lock", "pyproject.toml"):
        shutil.copy(REPOSITORY / name, root / name)
    shutil.copy(REPOSITORY / "CMakeLists.txt", root)
    return Checkout(root, state)


def steps(calls: list[str]) -> list[str]:
    """What set-up did, in words."""
    words = {"-m venv": "venv", "--requirement": "packages", "--editable": "extension"}
    return [next((words[key] for key in words if key in call), call) for call in calls]


def test_help_lists_every_command(checkout: Checkout) -> None:
    result = checkout.run("help")
    assert result.returncode == 0, result.stderr
    for command in (
        "all",
        "test",
        "check",
        "baseline",
        "compare",
        "features",
        "lint",
        "setup",
        "clean",
        "help",
        "--no-setup",
        "PYTHON=",
    ):
        assert f"  {command}" in result.stdout


def test_an_unknown_command_exits_2_with_the_usage(checkout: Checkout) -> None:
    result = checkout.run("rander")
    assert result.returncode == 2
    assert "unknown command: rander" in result.stderr
    assert "Usage: ./bench COMMAND" in result.stderr


def test_set_up_does_what_is_missing_and_a_second_time_nothing(checkout: Checkout) -> None:
    first = checkout.run("setup")
    assert first.returncode == 0, first.stderr
    assert steps(checkout.calls()) == ["venv", "packages", "extension"]

    second = checkout.run("setup")
    assert second.returncode == 0, second.stderr
    assert checkout.calls() == []
    assert second.stderr == "bench: everything is there\n"


def test_an_interrupted_first_run_is_done_again(checkout: Checkout) -> None:
    checkout.arrange("no-network")
    broken = checkout.run("setup")
    assert broken.returncode == 1
    assert "failed" in broken.stderr
    assert steps(checkout.calls()) == ["venv", "packages"]

    (checkout.state / "no-network").unlink()
    assert checkout.run("setup").returncode == 0
    assert steps(checkout.calls()) == ["venv", "packages", "extension"]


def test_only_what_changed_is_set_up_again(checkout: Checkout) -> None:
    assert checkout.run("setup").returncode == 0
    checkout.calls()

    (checkout.root / "haste_cuda" / "__init__.py").write_text("# changed\n")
    assert checkout.run("setup").returncode == 0
    assert steps(checkout.calls()) == []

    (checkout.root / "haste_cuda" / "core" / "config.h").write_text("// two\n")
    assert checkout.run("setup").returncode == 0
    assert steps(checkout.calls()) == ["extension"]

    with (checkout.root / "requirements.lock").open("a") as lock:
        lock.write("# changed\n")
    assert checkout.run("setup").returncode == 0
    assert steps(checkout.calls()) == ["venv", "packages", "extension"]


def test_a_moved_repository_gets_a_new_environment(checkout: Checkout) -> None:
    assert checkout.run("setup").returncode == 0
    checkout.calls()
    moved = Checkout(checkout.root.with_name("moved"), checkout.state)
    checkout.root.rename(moved.root)
    assert moved.run("setup").returncode == 0
    assert steps(moved.calls()) == ["venv", "packages", "extension"]


def test_nothing_is_fetched_where_everything_is_there(checkout: Checkout) -> None:
    assert checkout.run("setup").returncode == 0
    checkout.calls()
    checkout.arrange("no-network", "apt-is-broken")
    for command in ("setup", "test", "check"):
        checkout.run(command)
    assert [call for call in checkout.calls() if "pip" in call or "apt-get" in call] == []


def test_a_missing_package_is_installed_without_fetching_the_lists(checkout: Checkout) -> None:
    (checkout.state / "bin" / "git").unlink()
    result = checkout.run("setup")
    assert result.returncode == 0, result.stderr
    apt = [call for call in checkout.calls() if call.startswith("apt-get")]
    assert apt == ["apt-get install --yes --no-install-recommends git"]


def test_the_package_lists_are_fetched_where_installing_needs_them(checkout: Checkout) -> None:
    (checkout.state / "bin" / "git").unlink()
    checkout.arrange("no-lists")
    result = checkout.run("setup")
    assert result.returncode == 0, result.stderr
    apt = [call.split()[1] for call in checkout.calls() if call.startswith("apt-get")]
    assert apt == ["install", "update", "install"]


def test_the_tests_get_their_own_packages_once_and_no_other_command_asks(
    checkout: Checkout,
) -> None:
    for name in ("sbatch", "chromium"):
        (checkout.state / "bin" / name).unlink()
    assert checkout.run("setup").returncode == 0
    assert [call for call in checkout.calls() if "apt-get" in call] == []
    assert checkout.run("test").returncode == 0
    wanted = "apt-get install --yes --no-install-recommends slurm-wlm munge chromium"
    assert [call for call in checkout.calls() if "apt-get" in call] == [wanted]
    assert checkout.run("test").returncode == 0
    assert checkout.calls() == [PYTEST]


def test_tests_run_where_their_own_packages_cannot_be_installed(checkout: Checkout) -> None:
    for name in ("sbatch", "chromium"):
        (checkout.state / "bin" / name).unlink()
    checkout.arrange("apt-is-broken")
    result = checkout.run("test")
    assert result.returncode == 0, result.stderr
    assert "the test of profiles/slurm will be skipped: no slurm-wlm munge" in result.stderr
    assert "the tests of the report in a browser will be skipped: no chromium" in result.stderr
    assert checkout.calls()[-1] == PYTEST


def is_refusal_with_the_command(result: subprocess.CompletedProcess[str]) -> bool:
    """Whether `bench` gave up, and said what to type as root."""
    wanted = (
        "cannot be installed from here: git",
        "apt-get update && apt-get install --yes git\n",
    )
    return result.returncode == 1 and all(text in result.stderr for text in wanted)


def test_a_failing_apt_get_is_reported_with_the_exact_command(checkout: Checkout) -> None:
    (checkout.state / "bin" / "git").unlink()
    checkout.arrange("apt-is-broken")
    result = checkout.run("setup")
    assert is_refusal_with_the_command(result), (result.returncode, result.stderr)
    assert [call for call in checkout.calls() if call.startswith("python")] == []


def test_a_machine_without_apt_get_is_told_the_exact_command(checkout: Checkout) -> None:
    for name in ("git", "apt-get"):
        (checkout.state / "bin" / name).unlink()
    result = checkout.run("setup")
    assert is_refusal_with_the_command(result), (result.returncode, result.stderr)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user")
def test_a_user_whom_sudo_refuses_is_told_the_exact_command(checkout: Checkout) -> None:
    (checkout.state / "bin" / "git").unlink()
    checkout.arrange("sudo-is-refused")
    private = [folder for folder in checkout.root.parents if folder.stat().st_uid == os.geteuid()]
    modes = {folder: folder.stat().st_mode for folder in private}
    for folder in private:
        folder.chmod(modes[folder] | 0o055)
    try:
        result = checkout.run("setup", user="nobody")
    finally:
        for folder in private:
            folder.chmod(modes[folder])
    assert is_refusal_with_the_command(result), (result.returncode, result.stderr)
    assert checkout.calls() == [], "apt-get was tried without the right to"


def test_an_old_python_is_refused_with_the_versions_that_serve(checkout: Checkout) -> None:
    checkout.arrange("python-is-old")
    result = checkout.run("setup")
    assert result.returncode == 1
    assert "Python 3.11, 3.12 or 3.13 is needed" in result.stderr


def test_no_setup_without_an_environment_names_what_is_missing(checkout: Checkout) -> None:
    result = checkout.run("test", "--no-setup")
    assert result.returncode == 1
    assert "there is no .venv/bin/python" in result.stderr
    assert checkout.calls() == []


@pytest.fixture
def elsewhere(checkout: Checkout, tmp_path: Path) -> Path:
    """A folder of somebody's scenes, far from the checkout, which is set up."""
    folder = tmp_path / "my scenes"
    (folder / "more").mkdir(parents=True)
    for name in ("room.xml", "more/hall.xml", "mine.yaml"):
        (folder / name).touch()
    assert checkout.run("setup").returncode == 0
    checkout.calls()
    return folder


@pytest.mark.parametrize(
    ("typed", "passed_on"),
    [
        (["features", "room.xml"], "harness features {0}/room.xml"),
        (
            ["features", "cornell-box", "more", "more/hall.xml"],
            "harness features cornell-box more {0}/more/hall.xml",
        ),
        (["features", "no.xml"], "harness features no.xml"),
        (
            ["all", "--config", "scenes=room.xml"],
            "snakemake all --config scenes={0}/room.xml",
        ),
        (
            ["all", "--config", "scenes=[room.xml, skull,more/hall.xml]", "models=[path]"],
            "snakemake all --config scenes=[{0}/room.xml,skull,{0}/more/hall.xml] models=[path]",
        ),
        (
            ["all", "--configfile", "mine.yaml", "--configfile=mine.yaml"],
            "snakemake all --configfile {0}/mine.yaml --configfile={0}/mine.yaml",
        ),
        (
            ["all", "--configfile", "config/full.yaml"],
            "snakemake all --configfile config/full.yaml",
        ),
        (["test", "room.xml"], f"{PYTEST.removeprefix('python -m ')} room.xml"),
    ],
)
def test_paths_mean_what_they_mean_where_the_command_was_typed(
    checkout: Checkout, elsewhere: Path, typed: list[str], passed_on: str
) -> None:
    result = checkout.run(*typed, folder=elsewhere)
    assert result.returncode == 0, result.stderr
    assert checkout.calls() == [f"python -m {passed_on.format(elsewhere)}"]


def run_here(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`bench` with the interpreter of these tests and the machine as it is."""
    return subprocess.run(
        [str(root / "bench"), *arguments, "--no-setup"],
        env=os.environ | {"PYTHON": sys.executable},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


@pytest.fixture
def small_project(tmp_path: Path) -> Path:
    root = tmp_path / "a path with spaces"
    root.mkdir()
    shutil.copy(REPOSITORY / "bench", root)
    return root


def test_tests_run_from_a_path_with_spaces(small_project: Path) -> None:
    (small_project / "test_small.py").write_text("def test_one():\n    pass\n")
    result = run_here(small_project, "test", "-q", "-p", "no:cacheprovider", "test_small.py")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "1 passed" in result.stdout


FAULTY = """
import pytest

@pytest.mark.parametrize("albedo", [0.5, 2.0])
def test_no_surface_reflects_more_than_it_receives(albedo):
    assert albedo <= 1.0, f"a surface of albedo {albedo}"

def test_another_thing():
    pass
"""


def test_a_failure_of_one_of_several_processes_is_printed_with_its_message(
    small_project: Path,
) -> None:
    for name in ("test_first.py", "test_second.py"):
        (small_project / name).write_text(FAULTY)
    result = run_here(small_project, "test", "-n2", "-p", "no:cacheprovider")
    assert result.returncode == 1, result.stdout + result.stderr
    for name in ("test_first.py", "test_second.py"):
        nodeid = f"{name}::test_no_surface_reflects_more_than_it_receives[2.0]"
        assert f"FAILED {nodeid}" in result.stdout, result.stdout
    assert result.stdout.count("E       AssertionError: a surface of albedo 2.0") == 2, (
        result.stdout
    )
    assert "2 failed, 4 passed" in result.stdout, result.stdout


def test_arguments_choose_tests_and_the_number_of_processes(small_project: Path) -> None:
    (small_project / "test_small.py").write_text(FAULTY)
    result = run_here(small_project, "test", "-n0", "-p", "no:cacheprovider", "-k", "another")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "1 passed, 2 deselected" in result.stdout, result.stdout


def test_an_interrupt_ends_every_process(small_project: Path) -> None:
    began = small_project / "began"
    sleep = "import pathlib, time\n\ndef test_sleep():\n    pathlib.Path('{}').touch()\n"
    (small_project / "test_small.py").write_text(sleep.format(began) + "    time.sleep(600)\n")
    # A shell has its background jobs ignore interrupts, and so would all that they start.
    heeding = ["env", "--default-signal=INT", str(small_project / "bench")]
    process = subprocess.Popen(
        [*heeding, "test", "-n2", "-p", "no:cacheprovider", "--no-setup"],
        env=os.environ | {"PYTHON": sys.executable},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    while not began.exists() and process.poll() is None:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    said, _ = process.communicate(timeout=120)
    assert process.returncode == 2, said
    assert "KeyboardInterrupt" in said, said
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)


def test_a_second_run_of_all_says_that_nothing_is_to_be_done(small_project: Path) -> None:
    (small_project / "Snakefile").write_text(
        'rule all:\n    output: "results/report.html"\n    shell: "touch {output:q}"\n'
    )
    first = run_here(small_project, "all", "--cores", "1")
    assert first.returncode == 0, first.stderr
    assert f"the report is {small_project}/results/report.html" in first.stderr

    second = run_here(small_project, "all", "--cores", "1")
    assert second.returncode == 0, second.stderr
    assert "Nothing to be done" in second.stderr


def test_clean_keeps_what_is_published(small_project: Path) -> None:
    for folder in ("results/published/run", "results/baseline", "results/scenes", "build", ".venv"):
        (small_project / folder).mkdir(parents=True)
    result = run_here(small_project, "clean")
    assert result.returncode == 0, result.stderr
    left = {str(path.relative_to(small_project)) for path in small_project.rglob("*")}
    assert left == {
        ".venv",
        "bench",
        "results",
        "results/baseline",
        "results/published",
        "results/published/run",
    }
