"""Mitsuba's current variant, its parser's settings, and its errors turned into ours."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from harness.scene.errors import SceneError

if TYPE_CHECKING:
    import mitsuba as mi

    ParserConfig = mi.parser.ParserConfig


@contextmanager
def active_variant(variant: str) -> Iterator[None]:
    """Make a Mitsuba variant current for a while. Where none was current before, it stays."""
    import mitsuba as mi

    before = mi.variant()
    mi.set_variant(variant)
    try:
        yield
    finally:
        if before is not None:
            mi.set_variant(before)


@contextmanager
def mitsuba_errors(source: str) -> Iterator[None]:
    """Turn an error of Mitsuba's parser or plugins, which names its place, into a `SceneError`."""
    try:
        yield
    except SceneError:
        raise
    except (RuntimeError, TypeError, ValueError, KeyError) as error:
        message = str(error)
        if message.startswith("["):
            message = message.partition("] ")[2]
        raise SceneError(source, [message.strip()]) from error


def parser_config(variant: str) -> "ParserConfig":
    """Mitsuba's parser, told to keep equal meshes and BSDFs apart and to instantiate in order."""
    import mitsuba as mi

    config = mi.parser.ParserConfig(variant)
    config.merge_meshes = False
    config.merge_equivalent = False
    config.parallel = False
    return config
