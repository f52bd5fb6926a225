"""What the jobs of a run begin and end with alike: a folder of their own, a scene, its tracers, and
a record of what was done where.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from harness.measure.config import Config, scene_name
from harness.measure.crew import Crew
from harness.measure.files import write_json
from harness.measure.own_folder import own_folder
from harness.measure.plan import Subject, subject_of
from harness.measure.progress import Progress
from harness.measure.provenance import provenance
from harness.scene import RenderSettings, Scene, Settings, load_scene, load_settings

PROVENANCE, DESCRIPTION = "provenance.json", "scene.json"


@dataclass(frozen=True, slots=True)
class SceneJob:
    """One scene in the hands of one job. Made by `scene_job`."""

    config: Config
    path: Path
    """of the scene"""
    folder: Path
    """of the results"""
    threads: int
    settings: Settings
    scene: Scene
    progress: Progress

    def crew(self, tracers: Iterable[str]) -> Crew:
        """Start a process for each of some tracers."""
        return Crew.of(self.config, tracers, self.threads)

    def subject(self, tracer: str, render: RenderSettings) -> Subject:
        """Name a tracer on the scene, see `subject_of`."""
        recentre = self.settings.recentre
        return subject_of(self.scene, tracer, render, self.threads, recentre=recentre)

    def note_provenance(self, **more: object) -> None:
        """Write where and from what the results come, and what else is known of that."""
        about = provenance(self.config, self.scene, self.threads)
        write_json(self.folder / PROVENANCE, {**about, **more})

    def describe(self, **what: object) -> None:
        """Write what the results are of."""
        own = {"name": self.scene.name, "title": self.settings.title, "sha256": self.scene.sha256}
        write_json(self.folder / DESCRIPTION, {**own, **what})

    def finish(self, summary: str, **what: object) -> Path:
        """Write the summary, whose being there says that all the rest is; its path is returned."""
        path = self.folder / summary
        write_json(path, what)
        return path


@contextmanager
def scene_job(
    config: Config,
    path: Path,
    folder: Path,
    work: str,
    threads: int,
    *,
    title: str = "",
    size: tuple[int | None, int | None] = (None, None),
    shared: bool = False,
) -> Iterator[SceneJob]:
    """Have the folder of a scene's results to oneself, with the scene imported.

    Parameters
    ----------
    config
        The run's settings.
    path
        The scene.
    folder
        Where the results of the scene go.
    work, shared
        As of `own_folder`.
    threads
        Processor threads of every tracer; one traces at a time.
    title
        Opens every line of the progress; the name of the scene where it is empty.
    size
        Width and height of the scene's images, [pixels], where they are not those of the scene.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    """
    with own_folder(folder, work, title or scene_name(path), shared=shared) as progress:
        settings = load_settings(path)
        width, height = size
        scene = load_scene(path, width=width, height=height, recentre=settings.recentre)
        yield SceneJob(config, path, folder, threads, settings, scene, progress)
