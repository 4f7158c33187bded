"""The recipes of docs/howto.md: they run as they stand, in order, and make what they show."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

import first_hour
from checkout import ROOT

RECIPES = first_hour.recipes()
SMALL = "32x18"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder that all recipes run in, one after the other."""
    return tmp_path_factory.mktemp("howto")


@pytest.fixture(scope="module")
def env(tmp_path_factory):
    return first_hour.environment(tmp_path_factory.mktemp("commands"))


@pytest.mark.slow
@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.title)
def test_a_recipe_makes_what_it_names(recipe, folder, env):
    first_hour.run(recipe, folder, env, SMALL)
    for name in {*recipe.outputs, *recipe.pictures}:
        path = folder / name
        assert path.stat().st_size > 0, name
        if path.suffix == ".png":
            assert np.asarray(Image.open(path).convert("RGB")).max() > 60, f"{name} is black"


def test_every_recipe_names_its_picture_and_the_page_has_it():
    assert len(RECIPES) == 12
    for recipe in RECIPES:
        assert recipe.blocks, recipe.title
        assert len(recipe.pictures) == 1, recipe.title
        name = recipe.pictures[0]
        with Image.open(ROOT / "docs" / "howto" / name) as picture:
            assert picture.size <= (480, 270)
            assert np.asarray(picture.convert("RGB")).max() > 60, f"{name} is black"
