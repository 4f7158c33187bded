"""Files that change, are replaced and go."""

from rtbow.view.watch import Watch


def test_changes_are_found_once(tmp_path):
    watch, file = Watch(), tmp_path / "a.toml"
    file.write_text("1")
    watch.follow("scene", [file])
    assert watch.changed(0.0) == set()
    file.write_text("22")
    assert watch.changed(1.0) == {"scene"}
    assert watch.changed(2.0) == set()


def test_a_file_that_is_replaced_is_not_gone(tmp_path):
    watch, file = Watch(), tmp_path / "a.toml"
    file.write_text("1")
    watch.follow("scene", [file])
    file.unlink()
    for now in (0.0, 0.5, 0.9):
        assert watch.changed(now) == set()
        assert watch.missing("scene") == []
    file.write_text("22")
    assert watch.changed(1.2) == {"scene"}
    assert watch.missing("scene") == []


def test_a_file_that_stays_away_is_missing_until_it_comes_back(tmp_path):
    watch, file, other = Watch(), tmp_path / "a.toml", tmp_path / "b.csv"
    file.write_text("1")
    other.write_text("1")
    watch.follow("scene", [file])
    watch.follow("data", [other])
    aside = file.rename(tmp_path / "c.toml")
    watch.changed(0.0)
    watch.changed(1.1)
    assert watch.missing("scene") == [file]
    assert watch.missing("data") == []
    aside.rename(file)
    watch.changed(2.0)
    assert watch.missing("scene") == []
