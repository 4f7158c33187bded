"""Files that change, are replaced and go."""

import os

from rtbow.view.document.watch import Watch


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
    file.write_text("22")
    assert watch.changed(1.2) == {"scene"}


def test_a_file_that_stays_away_is_told_once_and_again_when_it_is_back(tmp_path):
    watch, file, other = Watch(), tmp_path / "a.toml", tmp_path / "b.csv"
    file.write_text("1")
    other.write_text("1")
    watch.follow("scene", [file])
    watch.follow("data", [other])
    aside = file.rename(tmp_path / "c.toml")
    assert watch.changed(0.0) == set()
    assert watch.changed(1.1) == {"scene"}
    assert watch.changed(2.0) == set()
    aside.rename(file)  # just as it was
    assert watch.changed(3.0) == {"scene"}
    assert watch.changed(4.0) == set()


def test_either_time_or_size_tells_of_a_change(tmp_path):
    watch, file = Watch(), tmp_path / "a.toml"
    file.write_text("1")
    os.utime(file, (1e9, 1e9))
    watch.follow("scene", [file])
    file.write_text("2")
    os.utime(file, (2e9, 2e9))
    assert watch.changed(0.0) == {"scene"}
    file.write_text("333")
    os.utime(file, (2e9, 2e9))
    assert watch.changed(1.0) == {"scene"}


def test_what_changed_before_it_is_followed_again_is_found_unless_anew(tmp_path):
    watch, file, other = Watch(), tmp_path / "a.toml", tmp_path / "b.toml"
    file.write_text("1")
    watch.follow("scene", [file])
    file.write_text("22")
    watch.follow("scene", [file, other])
    assert watch.changed(0.0) == {"scene"}
    file.write_text("333")
    watch.follow("scene", [file], anew=True)
    assert watch.changed(1.0) == set()
