import numpy as np
import pytest
from openrois_avatar.engines.figure.shading import CLOTH, PLAIN, SKIN, Bytes, Lighting, Surface, linear

HERE = np.eye(3, dtype=np.float32)
TO_VIEWER, TO_KEY, DOWN = (0.0, -1.0, 0.0), (-0.49, -0.67, 0.56), (0.0, -0.3, -0.95)


def lit(surface: Surface, *normals: tuple[float, float, float], rotation: np.ndarray = HERE) -> Bytes:
    directions = np.asarray(normals, np.float32)
    return Lighting([surface]).colours(slice(None), directions, rotation.astype(np.float32))


def test_a_colour_is_made_linear() -> None:
    assert linear("#ff8000") == pytest.approx([1.0, (128 / 255) ** 2, 0.0])


def test_surface_that_faces_the_light_is_brighter() -> None:
    surface = Surface(np.tile(linear("#808080"), (2, 1)), finish=CLOTH)
    bright, dark = lit(surface, TO_KEY, DOWN).astype(int).sum(axis=1)
    assert bright > dark + 100


def test_turning_the_surface_is_turning_its_normals() -> None:
    half = np.diag([-1.0, -1.0, 1.0])
    surface = Surface(np.tile(linear("#808080"), (1, 1)), finish=SKIN)
    assert (lit(surface, (0.6, 0.8, 0.0), rotation=half) == lit(surface, (-0.6, -0.8, 0.0))).all()


def test_no_colour_reaches_the_value_that_the_renderer_wraps_at() -> None:
    surface = Surface(np.full((1, 3), 9.0), finish=SKIN, gloss=5.0)
    assert set(lit(surface, TO_KEY).ravel()) == {249}


def test_a_fold_is_darker_and_in_skin_redder() -> None:
    albedo = np.tile(linear("#c0c0c0"), (2, 1))
    open_, fold = lit(Surface(albedo, np.asarray([1.0, 0.4]), SKIN), TO_VIEWER, TO_VIEWER).astype(float)
    assert (fold < open_).all()
    assert fold[0] / fold[2] > open_[0] / open_[2]


def test_gloss_shines_between_light_and_viewer() -> None:
    albedo = np.tile(linear("#404040"), (1, 1))
    dull, shiny = (lit(Surface(albedo, gloss=gloss), (-0.29, -0.95, 0.33)).sum() for gloss in (0.0, 0.5))
    assert shiny > dull + 50


def test_openness_can_change_for_one_part_alone() -> None:
    first, second = (Surface(np.tile(linear("#808080"), (2, 1)), finish=PLAIN) for _ in range(2))
    lighting = Lighting([first, second])
    normals = np.tile(np.asarray(TO_VIEWER, np.float32), (4, 1))
    before = lighting.colours(slice(None), normals, HERE)
    lighting.set_openness(slice(2, 4), np.asarray([0.2, 0.2]))
    after = lighting.colours(slice(None), normals, HERE)
    assert (after[:2] == before[:2]).all()
    assert (after[2:] < before[2:]).all()
    assert (lighting.colours(slice(2, 4), normals[2:], HERE) == after[2:]).all()
