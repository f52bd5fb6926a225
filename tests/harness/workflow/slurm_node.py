"""A SLURM of one node, this machine, for one test: its daemons run from a folder, as this user."""

from __future__ import annotations

import getpass
import os
import platform
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Daemons lie where only root's PATH looks.
PATH = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"])
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "sinfo", "scancel")
PATIENCE = 60.0
"""Seconds in which a daemon is ready or has failed."""


def missing_programs() -> list[str]:
    """What of SLURM and MUNGE is not installed."""
    return [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]


def _free_ports(count: int) -> list[int]:
    """Ports that nobody listens at; all are held until the last is found, so that they differ."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


def _configuration(folder: Path, cores: int) -> str:
    host, user = platform.node().partition(".")[0], getpass.getuser()
    controller, daemon = _free_ports(2)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20
    return f"""
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def _wait_until(what: str, ready: object, daemon: subprocess.Popen[bytes], log: Path) -> None:
    deadline = time.monotonic() + PATIENCE
    while not ready():
        if daemon.poll() is not None or time.monotonic() > deadline:
            text = log.read_text(errors="replace") if log.exists() else ""
            raise RuntimeError(f"{what} is not ready:\n{text[-4000:]}")
        time.sleep(0.1)


@contextmanager
def slurm_node(cores: int) -> Iterator[dict[str, str]]:
    """Start MUNGE and SLURM, and stop them; the environment in which SLURM's commands find them.

    Raises RuntimeError with a daemon's log if it does not start.
    """
    # Not in the test's own folder: the path of a socket has at most 107 characters.
    folder = Path(tempfile.mkdtemp(prefix="slurm-"))
    configuration = folder / "slurm.conf"
    configuration.write_text(_configuration(folder, cores))
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir()
    # Within a job the executor calls srun without the variables of SLURM that it does not know.
    srun = folder / "bin" / "srun"
    program = shutil.which("srun", path=PATH)
    srun.write_text(f'#!/bin/sh\nSLURM_CONF={configuration} exec {program} "$@"\n')
    srun.chmod(0o755)
    environment = {
        "PATH": os.pathsep.join([str(srun.parent), PATH]),
        "SLURM_CONF": str(configuration),
    }
    key = folder / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(secrets.token_bytes(128))
    daemons: list[subprocess.Popen[bytes]] = []

    def start(name: str, *arguments: str) -> tuple[subprocess.Popen[bytes], Path]:
        log = folder / f"{name}.log"
        with log.open("wb") as file:
            daemon = subprocess.Popen(
                [str(shutil.which(name, path=PATH)), *arguments],
                env={**os.environ, **environment},
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
            )
        daemons.append(daemon)
        return daemon, log

    def ask(*command: str) -> str:
        done = subprocess.run(
            command, env={**os.environ, **environment}, capture_output=True, text=True, check=False
        )
        return done.stdout.strip()

    try:
        files = {"key-file": "key", "socket": "socket", "pid-file": "pid", "seed-file": "seed"}
        options = [f"--{option}={folder}/munge.{file}" for option, file in files.items()]
        munged = start("munged", "--foreground", "--force", *options)
        _wait_until("munged", (folder / "munge.socket").exists, *munged)
        controller = start("slurmctld", "-D")
        _wait_until("slurmctld", lambda: "UP" in ask("scontrol", "ping"), *controller)
        node = start("slurmd", "-D")
        _wait_until("slurmd", lambda: ask("sinfo", "-h", "-o", "%T") == "idle", *node)
        yield environment
    finally:
        ask("scancel", "--me")
        deadline = time.monotonic() + PATIENCE
        while ask("squeue", "-h", "-t", "running,completing") and time.monotonic() < deadline:
            time.sleep(0.2)
        for daemon in reversed(daemons):
            daemon.terminate()
            daemon.wait()
        shutil.rmtree(folder, ignore_errors=True)
