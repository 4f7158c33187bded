"""The document that ``tools/make_api.py`` writes."""

import re

import make_api
import rtbow


def test_the_page_is_up_to_date():
    page = make_api.PAGE.read_text(encoding="utf-8")
    assert page == make_api.api_page(), "run python tools/make_api.py"


def test_every_public_name_is_there_with_its_examples():
    page = make_api.api_page()
    named = re.findall(r"(?m)^## `rtbow\.(\w+)`$", page)
    assert {*named} == {*rtbow.__all__} - {"__version__"}
    assert "### `Renderer.render`" in page
    assert page.count("```") % 2 == 0
    for leak in (":class:", ":func:", "``", "rtbow.scene.model", "collections.abc"):
        assert leak not in page.replace("```", "")
