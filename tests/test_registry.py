"""Names are found, refused twice, and told when there is no such thing."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import pytest

from mkt.registry import Registry, by_group, import_all, natural


def filled(*names, **options):
    registry = Registry("thing", **options)
    for name in names:
        registry.add(name, name.upper())
    return registry


def test_a_registry_is_a_mapping_in_the_order_of_registration():
    things = filled("b", "a")
    assert dict(things) == {"b": "B", "a": "A"} and list(things) == ["b", "a"]
    assert len(things) == 2 and "a" in things and "c" not in things
    assert things.get("c") is None


def test_an_order_sorts_the_names():
    assert list(filled("fig10", "fig2", order=natural)) == ["fig2", "fig10"]


def test_groups_come_in_their_order_and_names_of_no_group_last():
    names = ["aa.x", "old.fig10", "old.fig2", "new.fig1"]
    key = by_group(("old", "new"), ".")
    assert sorted(names, key=key) == ["old.fig2", "old.fig10", "new.fig1", "aa.x"]


def test_the_decorator_gives_the_function_back():
    things = Registry("thing")

    @things.register("one")
    def one():
        return 1

    assert one() == 1 and things["one"] is one


def test_a_name_is_a_text():
    with pytest.raises(ValueError, match="thing 5: a name is a text"):
        Registry("thing").add(5, "five")


def test_a_name_cannot_be_taken_twice():
    with pytest.raises(ValueError, match="thing a: registered twice"):
        filled("a", "a")


@pytest.mark.parametrize(
    "name, says",
    [
        ("fig44", "no thing 'fig44', perhaps t.fig4.*; there are t.fig4, t.bear"),
        ("bear", "no thing 'bear', perhaps t.bear; there are t.fig4, t.bear"),
        ("r", "no thing 'r'; there are t.fig4, t.bear"),
        ("xyz", "no thing 'xyz'; there are t.fig4, t.bear"),
        (3, "no thing '3'; there are t.fig4, t.bear"),
        (["bear"], "no thing .*; there are t.fig4, t.bear"),
    ],
)
def test_an_unknown_name_is_told_with_similar_ones_and_all_of_them(name, says):
    things = filled("t.fig4", "t.bear")
    with pytest.raises(ValueError, match=says.replace("?", r"\?")) as caught:
        things[name]
    assert "?" not in str(caught.value)
    assert isinstance(caught.value, KeyError)  # what a Mapping raises
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_of_many_names_a_message_has_only_the_similar_ones_and_what_lists_all():
    things = Registry("thing", listing="mkt thing --list")
    for name in ("t.bear", "t.fig4"):
        things.add(name, name)
    says = "no thing 'bear', perhaps t.bear; `mkt thing --list` lists all"
    with pytest.raises(ValueError, match=f"^{says}$") as caught:
        things["bear"]
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def package(folder, monkeypatch, name, **modules):
    """A package with a registry of its modules."""
    (folder / name).mkdir()
    made = f"things = Registry('thing', '{name}')\n"
    registry = f"from mkt.registry import Registry\n{made}"
    for module, code in {"__init__": registry, **modules}.items():
        (folder / name / f"{module}.py").write_text(code)
    monkeypatch.syspath_prepend(folder)
    return folder / name


def test_modules_are_imported_when_somebody_asks_and_not_before(tmp_path, monkeypatch):
    adds = "from shelf import things\nthings.add(__name__, 1)\n"
    deep = package(tmp_path, monkeypatch, "shelf", one=adds) / "deep"
    deep.mkdir()
    (deep / "__init__.py").write_text("")
    (deep / "two.py").write_text(adds)
    import shelf

    assert shelf.things._entries == {}
    assert set(shelf.things) == {"shelf.one", "shelf.deep.two"}
    import_all("shelf")  # once more is harmless


def test_a_discovery_that_was_stopped_can_be_taken_up_again(tmp_path, monkeypatch):
    stopping = (
        "import drawer\ndrawer.things.add('a', 1)\n"
        "if not hasattr(drawer, 'stopped'):\n"
        "    drawer.stopped = True\n    raise KeyboardInterrupt\n"
        "drawer.things.add('b', 2)\n"
    )
    package(tmp_path, monkeypatch, "drawer", one=stopping)
    monkeypatch.setattr(Registry, "_stopped", set())
    import drawer

    with pytest.raises(KeyboardInterrupt):
        set(drawer.things)
    assert dict(drawer.things) == {"a": 1, "b": 2}
    with pytest.raises(ValueError, match="a: registered twice"):
        drawer.things.add("a", 3)


def test_what_was_written_in_a_notebook_can_be_written_again(monkeypatch):
    things = Registry("thing")
    things.add("theirs", len)
    for number in 1, 2:
        mine = type("Mine", (), {"__module__": "__main__", "number": number})
        things.add("mine", mine())
        with pytest.raises(ValueError, match="theirs: registered twice"):
            things.add("theirs", mine())
    assert things["mine"].number == 2


def test_a_second_thread_waits_for_all_names(tmp_path, monkeypatch):
    slow = "import time, chest\ntime.sleep(0.3)\nchest.things.add('a', 1)\n"
    package(tmp_path, monkeypatch, "chest", one=slow)
    import chest

    with ThreadPoolExecutor(3) as threads:
        asked = [threads.submit(lambda: chest.things["a"]) for _ in range(3)]
        assert [one.result() for one in asked] == [1, 1, 1]


def test_natural_order_is_that_of_people():
    names = ["fig10", "a.fig2", "fig2", "10", "fig2b", "9"]
    assert sorted(names, key=natural) == ["9", "10", "a.fig2", "fig2", "fig2b", "fig10"]
