"""Folders of particles: what is written is read again, and mended labels are taken as they are."""

import json
from pathlib import Path

import numpy as np
import pytest

from jaxtex.core.errors import InputError
from jaxtex.io.images import read_image, write_image
from jaxtex.particles.files import has_mended_labels, read_particles, write_particles
from jaxtex.particles.things import Decomposition, describe_particles


@pytest.fixture
def decomposed(tmp_path: Path) -> Decomposition:
    labels = np.zeros((30, 40), int)
    labels[3:9, 4:12], labels[14:20, 4:12], labels[5:12, 25:33] = 1, 2, 3
    picture = np.random.default_rng(0).random((30, 40, 3))
    write_image(tmp_path / "things.png", picture)
    found = describe_particles(labels, [0, 1, 0])
    write_particles(tmp_path / "out", read_image(tmp_path / "things.png"), found, names=("leaf", "stone"))
    return found


def mend_labels(folder: Path, labels: np.ndarray) -> None:
    write_image(folder / "labels.png", labels[..., None] / 65535, colour_space="data", bits=16)


def test_what_is_written_is_read_again(tmp_path: Path, decomposed: Decomposition) -> None:
    folder = read_particles(tmp_path / "out")
    assert folder.names == ("leaf", "stone")
    np.testing.assert_array_equal(folder.decomposition.labels, decomposed.labels)
    assert folder.decomposition.particles == decomposed.particles
    assert folder.image.sha256 == read_image(tmp_path / "things.png").sha256


def test_a_folder_is_written_again_in_place(tmp_path: Path, decomposed: Decomposition) -> None:
    folder = read_particles(tmp_path / "out")
    write_particles(tmp_path / "out", folder.image, decomposed)
    assert read_particles(tmp_path / "out").names == ("class 0", "class 1")


def test_labels_mended_by_hand(tmp_path: Path, decomposed: Decomposition) -> None:
    labels = np.where(decomposed.labels == 2, 0, decomposed.labels)
    mend_labels(tmp_path / "out", labels)
    mended = read_particles(tmp_path / "out")
    assert mended.names == ("leaf",)
    assert [each.kind for each in mended.decomposition.particles] == [0, 0]


def test_that_labels_are_mended_is_known(tmp_path: Path, decomposed: Decomposition) -> None:
    assert not has_mended_labels(tmp_path)
    assert not has_mended_labels(tmp_path / "out")
    mend_labels(tmp_path / "out", np.where(decomposed.labels == 2, 0, decomposed.labels))
    assert has_mended_labels(tmp_path / "out")
    write_particles(tmp_path / "out", read_image(tmp_path / "things.png"), decomposed)
    assert not has_mended_labels(tmp_path / "out")
    for text in ("[" * 100_000, "{", "[]", "{}"):
        (tmp_path / "out" / "particles.json").write_text(text)
        assert has_mended_labels(tmp_path / "out")
    (tmp_path / "out" / "particles.json").unlink()
    assert has_mended_labels(tmp_path / "out")


def test_labels_and_classes_are_replaced_together(
    tmp_path: Path, decomposed: Decomposition, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    image, before = read_image(tmp_path / "things.png"), (tmp_path / "out" / "labels.png").read_bytes()
    fewer = describe_particles((decomposed.labels == 1).astype(int), [0])
    monkeypatch.setattr("jaxtex.particles.files.write_envelope", stop)
    with pytest.raises(KeyboardInterrupt):
        write_particles(tmp_path / "out", image, fewer)
    assert (tmp_path / "out" / "labels.png").read_bytes() == before
    assert not has_mended_labels(tmp_path / "out")
    assert {each.name for each in (tmp_path / "out").iterdir()} == {"labels.png", "particles.json", "picture.png"}


def test_labels_that_do_not_fit(tmp_path: Path, decomposed: Decomposition) -> None:
    mend_labels(tmp_path / "out", decomposed.labels + 1)
    with pytest.raises(InputError, match="a particle 4"):
        read_particles(tmp_path / "out")
    mend_labels(tmp_path / "out", decomposed.labels[:20])
    with pytest.raises(InputError, match=r"labels\.png: is 40 x 20"):
        read_particles(tmp_path / "out")
    mend_labels(tmp_path / "out", 0 * decomposed.labels)
    with pytest.raises(InputError, match="all 0"):
        read_particles(tmp_path / "out")


def test_folders_that_are_none(tmp_path: Path, decomposed: Decomposition) -> None:
    with pytest.raises(InputError, match="no such folder"):
        read_particles(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"holds no particles\.json"):
        read_particles(tmp_path)
    file = tmp_path / "out/particles.json"
    document = json.loads(file.read_text())
    document["particles"][0]["class"] = 7
    file.write_text(json.dumps(document))
    with pytest.raises(InputError, match="class 7"):
        read_particles(tmp_path / "out")
    (tmp_path / "out/picture.png").unlink()
    with pytest.raises(InputError, match=r"picture\.png"):
        read_particles(tmp_path / "out")


def test_what_does_not_belong_together(tmp_path: Path, decomposed: Decomposition) -> None:
    write_image(tmp_path / "small.png", np.zeros((5, 5, 1)))
    with pytest.raises(ValueError, match="5 x 5"):
        write_particles(tmp_path / "out", read_image(tmp_path / "small.png"), decomposed)
    with pytest.raises(ValueError, match="names"):
        write_particles(tmp_path / "out", read_image(tmp_path / "things.png"), decomposed, names=("one",))
