"""settings.yaml: defaults, values, refusals."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

from harness.scene import SceneError, Settings, load_settings
from harness.scene.settings import settings_schema


def write(folder: Path, text: str) -> Path:
    (folder / "settings.yaml").write_text(text)
    return folder


def test_a_folder_without_settings_gets_the_schemas_defaults(tmp_path: Path) -> None:
    settings = load_settings(tmp_path)
    assert settings == load_settings(tmp_path / "scene.xml")
    for name, rule in settings_schema()["properties"].items():
        value = getattr(settings, name)
        written = rule["default"]
        if name == "title":
            assert value == tmp_path.name
        else:
            assert value == (tuple(written) if isinstance(written, list) else written), name


def test_schema_and_record_have_the_same_keys_each_explained() -> None:
    properties = settings_schema()["properties"]
    assert list(properties) == [field.name for field in fields(Settings)]
    assert all(rule["description"] for rule in properties.values())


def test_values_are_taken_and_reach_the_render_settings(tmp_path: Path) -> None:
    folder = write(
        tmp_path, "models: [haste]\nmax_layers: 3\nambient: [0, 0.5, 1]\nresolution: [32, 16]"
    )
    settings = load_settings(folder)
    assert settings.models == ("haste",)
    render = settings.render("haste")
    assert (render.width, render.height, render.max_layers) == (32, 16, 3)
    assert render.ambient == (0.0, 0.5, 1.0)
    larger = settings.render("haste", width=640)
    assert (larger.width, larger.height) == (640, 16)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("max_layer: 3", "max_layer"),
        ("max_layers: 0", 'key "max_layers"'),
        ("max_depth: 2.5", 'key "max_depth"'),
        ("models: []", 'key "models"'),
        ("models: [path, path]", 'key "models"'),
        ("models: [radiosity]", "radiosity"),
        ("ambient: [0, -1, 0]", 'key "ambient.1"'),
        ("ambient: [0, 0]", 'key "ambient"'),
        ("resolution: [64, 0]", 'key "resolution.1"'),
        ("caustic: maybe", 'key "caustic"'),
        ("- a list", "object"),
        ("models: [path", "not valid YAML"),
    ],
)
def test_bad_settings_are_refused_with_file_and_key(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(SceneError) as caught:
        load_settings(write(tmp_path, text))
    assert message in str(caught.value)
    assert "settings.yaml" in str(caught.value)


def test_every_bad_key_is_named_in_one_error(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        load_settings(write(tmp_path, "max_depth: 0\nlight_samples: none\ncolour: red"))
    assert len(caught.value.problems) == 3


def test_a_settings_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"other\.yaml"):
        load_settings(tmp_path / "other.yaml")
