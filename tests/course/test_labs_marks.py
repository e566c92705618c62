"""Marks reach students: the table that a teacher fills in, and the pages."""

import json
import re
import shlex

import nbformat
import pytest

from mkt.course import cli
from mkt.course.labs import grading, marks, pages, table
from mkt.course.labs.notebooks import headings, labs, name, of_role, released
from mkt.files import PACKAGE, ROOT
from tests.course.toy_lab import GOOD, TOY, answer, graded, hand_in, meta

# Each starts students' programs; a quick loop leaves them out.
pytestmark = pytest.mark.slow


def page(output, student):
    (path,) = (output.with_name("grades_pages") / student).glob("*.html")
    return path.read_text(encoding="utf-8")


@pytest.fixture
def grades(toy):
    """The table of one student, who did half."""
    half = answer(**GOOD | {"add": "def add(a, b):\n    return a - b"})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", half)
    graded(toy / "submitted", toy / "grades.csv")
    return toy / "grades.csv"


def test_a_page_calls_parts_by_their_headings_and_never_by_the_marks_of_a_solution():
    for title, lab in labs().items():
        places = headings(lab)
        assert [place for place in places.values() if "SOLUTION" in place] == [], title


@pytest.mark.parametrize("title", labs())
def test_a_page_has_its_formulas_in_letters(title, tmp_path):
    output = tmp_path / "grades.csv"
    row = dict.fromkeys(table.NEEDED, "") | {"student": "ada", "lab": title}
    pages.write(output, row | {"total": "20"}, labs()[title], models=True)
    text = page(output, "ada")
    assert "Model answers" in text
    assert [line for line in text.splitlines() if "$" in line or "\\" in line] == []
    assert "Ada Lovelace" not in text


def typed(output, text, column="why"):
    """Type points, of the question `why`, as a German spreadsheet saves it."""
    found = table.read(output)
    found[0][column] = text
    table.write(output, found[0], found, ";")
    output.write_bytes(output.read_text(encoding="utf-8-sig").encode("cp1252"))


def test_the_page_says_what_was_right_the_sentences_and_the_points(grades):
    text = page(grades, "ada")
    assert "<strong>1 of 3 points</strong> by the checks" in text
    assert "check_add: 1 + 2 is 3, not -1" in text
    assert "I do not know." in text
    assert "SOLUTION" not in text
    assert "Because." not in text  # the model answer
    rubrics = grades.with_name("grades_rubrics.md").read_text(encoding="utf-8")
    assert "toy, why: 3 points" in rubrics and "Because." in rubrics


def test_a_page_says_nothing_of_other_students(toy):
    for student in ("ada", "bob"):
        hand_in(toy / "submitted" / student / "toy.ipynb", answer(**GOOD))
    (toy / "submitted" / "REST.ZIP").write_bytes(b"PK")
    rows = graded(toy / "submitted", toy / "grades.csv")
    assert "byte for byte, as bob" in rows["ada"]["note"]
    assert "bob" not in page(toy / "grades.csv", "ada")
    assert "unpack it" in next(r["note"] for r in rows.values() if ".ZIP" in r["file"])


def test_what_a_teacher_types_is_summed_up_and_then_the_page_has_the_model_answers(
    grades,
):
    typed(grades, "2,5")
    (row,) = merged(grades)
    assert (row["total"], row["maximum"]) == ("3,5", "6")
    text = page(grades, "ada")
    assert "3,5 of 6 points" in text
    assert "Because." in text and "return a + b" in text


def test_a_spreadsheet_that_takes_zeros_away_makes_no_other_student(toy):
    for student in ("0012345", "007"):
        hand_in(toy / "submitted" / student / "toy.ipynb", answer(**GOOD))
    grades = toy / "grades.csv"
    graded(toy / "submitted", grades)
    text = grades.read_text(encoding="utf-8-sig").replace("\n007,", "\n7,")
    grades.write_text(text.replace("\n0012345,", "\n12345,"), encoding="utf-8")
    assert {*graded(toy / "submitted", grades)} == {"0012345", "007"}
    assert len(table.read(grades)) == 2
    folders = {path.name for path in (toy / "grades_pages").iterdir() if path.is_dir()}
    assert folders == {"0012345", "007"}


def test_rows_without_a_total_are_named_and_older_ones_are_not(grades, toy, capsys):
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer(**GOOD))
    hand_in(toy / "submitted" / "eve" / "toy.zip", "PK")
    again = answer(**GOOD | {"why": "Why?\n\nNow I know."})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", again)
    graded(toy / "submitted", grades)
    capsys.readouterr()
    merged(grades)
    words = "no total yet, points missing: ada, toy: why; bob, toy: why\n"
    assert capsys.readouterr().err == words
    found = [row | {"why": "3" if row["lab"] else ""} for row in table.read(grades)]
    table.write(grades, list(found[0]), found, ",")
    merged(grades)
    assert capsys.readouterr().err == ""


def test_no_page_has_model_answers_while_work_is_handed_in(toy):
    """A row without answers has its total at once."""
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer())
    (row,) = graded(toy / "submitted", toy / "grades.csv").values()
    assert row["total"] == "0"
    assert "Because." not in page(toy / "grades.csv", "ada")
    merged(toy / "grades.csv")
    assert "Because." in page(toy / "grades.csv", "ada")


def test_pages_with_model_answers_stay_when_more_is_graded(grades, toy):
    """And new ones have none, until the table is summed up again."""
    typed(grades, "2,5")
    merged(grades)
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer())
    graded(toy / "submitted", grades)
    assert "Because." in page(grades, "ada")
    assert "Because." not in page(grades, "bob")
    merged(grades)
    assert "Because." in page(grades, "bob")


def test_a_check_that_a_teacher_gives_all_points_is_not_found_fault_with(toy):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(six=GOOD["six"]))
    graded(toy / "submitted", toy / "grades.csv")
    fault = "check_add: "
    assert fault in page(toy / "grades.csv", "ada")
    for typed, settled in ("1", False), ("2,0", True):
        rows = [row | {"check_add": typed} for row in table.read(toy / "grades.csv")]
        table.write(toy / "grades.csv", rows[0], rows, ",")
        merged(toy / "grades.csv")
        assert (fault not in page(toy / "grades.csv", "ada")) == settled
    assert "3 of 6 points" in page(toy / "grades.csv", "ada")


def test_that_a_check_was_edited_stands_on_the_page_whatever_its_points(toy):
    mine = answer(**GOOD)
    of_role(mine, "check")["check_add"].source = "pass"
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", mine)
    graded(toy / "submitted", toy / "grades.csv")
    said = "check_add: was edited, the original counts"
    assert said in page(toy / "grades.csv", "ada")


def test_points_that_were_typed_are_on_the_page_after_the_next_run(grades, toy):
    typed(grades, "2,5")
    graded(toy / "submitted", grades)
    assert "3,5 of 6 points" in page(grades, "ada")


def states_in(output):
    """The state of each file of a table."""
    return {row["file"]: row["state"] for row in table.read(output)}


def test_a_file_that_was_moved_has_one_page(grades, toy):
    """Two would look like two marks."""
    folder = toy / "submitted"
    first, second = folder / "ada" / "toy.ipynb", folder / "ada_toy.ipynb"
    first.rename(second)
    graded(toy / "submitted", grades)
    states = states_in(grades)
    assert states["ada/toy.ipynb"] == "gone" and states["ada_toy.ipynb"] == ""
    assert len(list((toy / "grades_pages" / "ada").glob("*.html"))) == 1
    second.rename(first)
    graded(toy / "submitted", grades)
    states = states_in(grades)
    assert states["ada_toy.ipynb"] == "gone" and states["ada/toy.ipynb"] == ""
    assert len(list((toy / "grades_pages" / "ada").glob("*.html"))) == 1


def test_a_file_that_is_gone_has_neither_total_nor_page(grades, toy):
    """Points that were typed stay too, and all is as before when it is there again."""
    typed(grades, "2,5")
    merged(grades)
    (before,) = table.read(grades)
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer())
    (toy / "submitted" / "ada").rename(toy / "aside")
    graded(toy / "submitted", grades)
    for row in (table.read(grades)[0], merged(grades)[0]):
        assert (row["why"], row["points"], row["total"]) == ("2,5", "1", "")
        assert not (toy / "grades_pages" / "ada").exists()
    (toy / "aside").rename(toy / "submitted" / "ada")
    graded(toy / "submitted", grades)
    assert table.read(grades)[0] == before
    assert "3,5 of 6 points" in page(grades, "ada")


def test_points_typed_for_text_in_another_place_go_with_that_text_alone(toy):
    notebook = answer(**GOOD | {"why": "Why?\n\nYOUR ANSWER HERE"})
    text = nbformat.v4.new_markdown_cell("Because I say so.")
    notebook.cells.insert(0, text)
    path = toy / "submitted" / "ada" / "toy.ipynb"
    hand_in(path, notebook)
    graded(toy / "submitted", toy / "grades.csv")
    typed(toy / "grades.csv", "2")
    notebook.cells.append(nbformat.v4.new_code_cell("add(1, 2)"))
    hand_in(path, notebook)
    graded(toy / "submitted", toy / "grades.csv")
    assert {row["why"] for row in table.read(toy / "grades.csv")} == {"2"}
    text.source = "Now I know."
    notebook.cells[0] = text
    hand_in(path, notebook)
    graded(toy / "submitted", toy / "grades.csv")
    assert {row["why"] for row in table.read(toy / "grades.csv")} == {"2", ""}


def test_everything_that_is_no_number_of_points_is_named_at_once(grades, toy):
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer(**GOOD))
    graded(toy / "submitted", grades)
    rows = [
        row | {"why": "drei" if row["student"] == "bob" else "-1"}
        for row in table.read(grades)
    ]
    table.write(grades, list(rows[0]), rows, ",")
    with pytest.raises(SystemExit, match="ada.*'-1'.*; bob.*'drei'"):
        merged(grades)


@pytest.mark.parametrize("text", ["4", "-1", "good", "nan", "inf", "0_1"])
def test_what_is_no_number_of_points_is_refused(grades, text):
    typed(grades, text)
    with pytest.raises(SystemExit, match="ada, toy: .* is not a number of points"):
        cli.run(cli.parse(["labs", "grade", "--merge", "-o", str(grades)]))


def test_no_typed_sum_of_checks_is_without_end(grades):
    typed(grades, "", "check_add")
    typed(grades, "inf", "points")
    with pytest.raises(
        SystemExit, match="'inf' in the table is not a number of points from 0 on"
    ):
        merged(grades)


def test_points_of_a_check_may_be_changed_too(grades):
    typed(grades, "2")
    typed(grades, "0,5", "check_add")
    (row,) = merged(grades)
    assert (row["points"], row["total"]) == ("1,5", "3,5")
    typed(grades, "99", "check_add")
    with pytest.raises(SystemExit, match="'99' in the table is not a number of points"):
        merged(grades)


def test_a_second_run_keeps_what_was_typed_and_grades_only_what_is_new(grades, toy):
    typed(grades, "3")
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer())
    graded(toy / "submitted", grades)
    totals = {row["student"]: row["total"] for row in table.read(grades)}
    assert totals == {"ada": "4", "bob": "0"}


def test_a_file_that_is_handed_in_again_keeps_the_points_of_the_same_answer(
    grades, toy
):
    """The older row says what it is, and its page is gone."""
    typed(grades, "2,5")
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    graded(toy / "submitted", grades)
    found = {row["points"]: row for row in table.read(grades)}
    assert {points: row["total"] for points, row in found.items()} == {
        "1": "",  # or a sum over the rows would count both
        "3": "5,5",
    }
    assert found["1"]["why"] == "2,5"
    assert found["1"]["state"] == "older"
    assert found["3"]["state"] == found["3"]["note"] == ""
    assert "5,5 of 6 points" in page(grades, "ada")
    merged(grades)
    assert "5,5 of 6 points" in page(grades, "ada")


@pytest.mark.parametrize("note", ["", "an older version.", "what a teacher wrote"])
def test_no_words_in_a_note_make_an_older_version_count(grades, toy, note):
    """A sum over the totals would count two versions."""
    typed(grades, "2,5")
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    graded(toy / "submitted", grades)
    rows = [row | {"note": note} for row in table.read(grades)]
    table.write(grades, rows[0], rows, ",")
    assert [row["total"] for row in merged(grades) if row["student"] == "ada"].count(
        ""
    ) == 1


def test_a_table_without_states_is_not_summed_up_before_it_has_them(grades, toy):
    rows = table.read(grades)
    columns = [name for name in rows[0] if name != "state"]
    rows = [row | {"note": "this file is no longer in the folder"} for row in rows]
    table.write(grades, columns, [{n: row[n] for n in columns} for row in rows], ",")
    with pytest.raises(ValueError, match="no column is called state; `labs grade`"):
        grading.merge(grades)
    graded(toy / "submitted", grades)
    grading.merge(grades)
    assert [(row["state"], row["note"]) for row in table.read(grades)] == [("", "")]


def test_points_of_another_answer_stay_in_the_older_row_and_the_new_one_says_so(
    grades, toy
):
    typed(grades, "2,5")
    again = answer(**GOOD | {"why": "Why?\n\nNow I know."})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", again)
    graded(toy / "submitted", grades)
    found = {row["points"]: row for row in table.read(grades)}
    assert found["3"]["why"] == found["3"]["total"] == ""
    assert found["3"]["note"] == pages.TYPED_ELSEWHERE
    assert found["1"]["why"] == "2,5"
    assert pages.TYPED_ELSEWHERE not in page(grades, "ada")
    table.write(
        grades, found["3"], [found["1"], found["3"] | {"why": "1"}], table.SEPARATORS[0]
    )
    assert {row["points"]: row["note"] for row in merged(grades)}["3"] == ""


def test_no_points_for_no_answer_are_none_that_were_typed(toy):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer())
    graded(toy / "submitted", toy / "grades.csv")
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    graded(toy / "submitted", toy / "grades.csv")
    found = {row["points"]: row for row in table.read(toy / "grades.csv")}
    assert (found["3"]["why"], found["3"]["note"]) == ("", "")


def test_a_version_that_is_handed_in_once_more_is_no_longer_an_older_one(grades, toy):
    first = (toy / "submitted" / "ada" / "toy.ipynb").read_text(encoding="utf-8")
    for text in (answer(**GOOD), first):
        hand_in(toy / "submitted" / "ada" / "toy.ipynb", text)
        graded(toy / "submitted", grades)
    states = {row["points"]: row["state"] for row in table.read(grades)}
    assert states == {"1": "", "3": "older"}
    assert "<strong>1 of 3 points</strong>" in page(grades, "ada")


def merged(output):
    """The rows of a table after it was summed up."""
    assert not cli.run(cli.parse(["labs", "grade", "--merge", "-o", str(output)]))
    return table.read(output)


@pytest.mark.parametrize("typed_in, total", [("2,5", "3,5"), ("2.5", "3.5")])
def test_sums_have_the_decimal_mark_of_what_was_typed(grades, toy, typed_in, total):
    """In all rows, and also where the typed number is a check's."""
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer())
    graded(toy / "submitted", grades)
    found = {row["student"]: row for row in table.read(grades)}
    found["ada"]["why"] = typed_in
    found["bob"]["check_add"] = "1.5"
    table.write(grades, found["ada"], found.values(), ";")
    rows = {row["student"]: row for row in merged(grades)}
    assert rows["ada"]["total"] == total
    assert rows["bob"]["total"] == total.replace("3", "1")
    assert rows["bob"]["points"] == total.replace("3", "1")
    assert rows["bob"]["check_add"] == "1.5"


def test_rows_of_a_teachers_own_stay_as_they_are_and_empty_lines_go(grades, toy):
    columns = list(table.read(grades)[0])
    own = dict.fromkeys(columns, "") | {"student": "average", "lab": "toy"}
    own |= {"points": "2.75", "total": "3", "why": "two"}
    blank = "," * (len(columns) - 1)
    table.write(grades, columns, [own, *table.read(grades)], ",")
    text = grades.read_text(encoding="utf-8-sig")
    grades.write_text(f"{text}{blank}\n", encoding="utf-8-sig")
    for _ in range(2):
        assert merged(grades)[1:] == [own]
        graded(toy / "submitted", grades)
        assert table.read(grades)[1:] == [own]
    assert not (toy / "grades_pages" / "average").exists()


def test_a_student_who_is_renamed_in_the_table_has_one_page(grades, toy):
    for again in (merged, lambda output: graded(toy / "submitted", output)):
        (row,) = table.read(grades)
        row["student"] += " Lovelace"
        table.write(grades, row, [row], ",")
        kept = toy / "grades_pages" / "mine" / "notes.html"
        hand_in(kept, "of the teacher")
        again(grades)
        found = sorted((toy / "grades_pages").glob("*/*.html"))
        assert [path.parent.name for path in found] == [row["student"], "mine"]
        assert len(list((toy / "grades_pages").iterdir())) == 2


def test_points_are_carried_over_from_the_last_of_several_versions():
    old = {"student": "ada", "lab": "toy", "file": "a"}
    old |= {"answers": "x", "note": "", "sha256": ""}
    rows = [old | {"why": "1"}, old | {"why": "2"}]
    row = old | {"sha256": "new", "why": ""}
    grading._carry_over(row, rows, {"toy": TOY})
    assert row["why"] == "2"


def test_a_file_that_is_moved_keeps_its_points_and_those_of_others_stay_theirs(
    grades, toy
):
    typed(grades, "2")
    moved = toy / "submitted" / "ada" / "toy.ipynb"
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", moved.read_text(encoding="utf-8"))
    moved.rename(toy / "submitted" / "ada_toy.ipynb")
    graded(toy / "submitted", grades)
    found = {row["file"]: row for row in table.read(grades)}
    assert found["ada_toy.ipynb"]["why"] == "2"
    assert found["ada/toy.ipynb"]["state"] == "gone"
    assert found["bob/toy.ipynb"]["why"] == ""


def test_points_of_the_file_itself_come_before_those_of_another_with_its_answer():
    ada = {"student": "ada", "lab": "toy", "answers": "x", "note": ""}
    rows = [
        ada | {"file": "ada/toy.ipynb", "sha256": "1", "why": "2"},
        ada | {"file": "ada_toy.ipynb", "sha256": "2", "why": "0"},
    ]
    row = ada | {"file": "ada/toy.ipynb", "sha256": "3", "why": ""}
    grading._carry_over(row, rows, {"toy": TOY})
    assert row["why"] == "2"


def test_what_could_not_be_read_has_no_answer_in_common_with_anything():
    unread = {"student": "ada", "lab": "toy", "answers": "", "note": "", "sha256": ""}
    rows = [unread | {"file": "ada/toy.docx", "why": "2"}]
    row = unread | {"file": "ada/toy.pdf", "why": ""}
    grading._carry_over(row, rows, {"toy": TOY})
    assert row["why"] == ""
    row = unread | {"file": "ada/toy.ipynb", "sha256": "1", "why": ""}
    grading._carry_over(row, rows, {"toy": TOY})
    assert row["why"] == ""


def test_of_two_files_of_a_student_each_has_the_points_of_its_own_answer(grades, toy):
    typed(grades, "2")
    other = answer(**GOOD | {"why": "Why?\n\nNow I know."})
    hand_in(toy / "submitted" / "ada_toy.ipynb", other)
    graded(toy / "submitted", grades)
    found = {row["file"]: row for row in table.read(grades)}
    assert (found["ada_toy.ipynb"]["why"], found["ada/toy.ipynb"]["why"]) == ("", "2")
    assert pages.TYPED_ELSEWHERE not in found["ada_toy.ipynb"]["note"]


def test_two_students_never_have_the_same_folder():
    """Neither by a mark that a folder cannot have, nor by a long name's beginning."""
    names = ["a/b", "a:b", "a_b", "x" * 99, "x" * 98, f"{'x' * 80}"]
    assert len({pages._safe(one) for one in names}) == len(names)


def test_an_answer_without_end_is_shortened_to_what_a_spreadsheet_holds(toy):
    long = answer(**GOOD | {"why": f"Why?\n\n{'So. ' * 50_000}"})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", long)
    graded(toy / "submitted", toy / "grades.csv")
    (row,) = table.read(toy / "grades.csv")
    assert len(row["answers"]) == table.ROOM
    end = "[shortened here; the whole is in ada/toy.ipynb]"
    assert row["answers"].endswith(end)
    typed(toy / "grades.csv", "2")
    (row,) = merged(toy / "grades.csv")
    assert row["total"] == "5" and row["answers"].endswith(end)


def test_a_table_with_the_line_ends_of_windows_keeps_points_and_answers(toy):
    lines = answer(**GOOD | {"why": "Why?\n\nIt has\ntwo lines."})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", lines)
    graded(toy / "submitted", toy / "grades.csv")
    typed(toy / "grades.csv", "2")
    text = table.read(toy / "grades.csv")[0]["answers"]
    unix = (toy / "grades.csv").read_bytes().replace(b"\r\n", b"\n")
    (toy / "grades.csv").write_bytes(unix.replace(b"\n", b"\r\n"))
    row = graded(toy / "submitted", toy / "grades.csv")["ada"]
    assert (row["why"], row["answers"]) == ("2", text)
    (toy / "grades.csv").write_bytes(unix.replace(b"\n", b"\r\n"))
    (row,) = merged(toy / "grades.csv")
    assert (row["total"], row["answers"]) == ("5", text)


def test_an_older_table_with_a_longer_answer_can_be_read(grades):
    text = grades.read_text(encoding="utf-8-sig")
    long = text.replace("I do not know.", "I do not know. " * 20_000)
    grades.write_text(long.replace(",0,1,,", ",0,1,3,"), encoding="utf-8")
    (row,) = merged(grades)
    assert row["total"] == "4" and len(row["answers"]) == table.ROOM


def test_columns_that_a_teacher_has_added_stay(grades, toy):
    found = [row | {"comment": "see me"} for row in table.read(grades)]
    table.write(grades, found[0], found, ",")
    assert merged(grades)[0]["comment"] == "see me"
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer())
    graded(toy / "submitted", grades)
    comments = {row["student"]: row["comment"] for row in table.read(grades)}
    assert comments == {"ada": "see me", "bob": ""}


def test_text_in_a_column_without_a_heading_is_not_thrown_away(grades):
    found = [row | {"comment": "see me"} for row in table.read(grades)]
    table.write(grades, found[0], found, ",")
    text = grades.read_text(encoding="utf-8-sig")
    for nameless in (text.replace(",comment", ","), text.replace(",comment", "")):
        grades.write_text(nameless, encoding="utf-8")
        with pytest.raises(SystemExit, match="grades.csv: .* without a heading; write"):
            merged(grades)


def test_a_table_that_has_lost_a_column_says_which(grades, toy):
    whole = grades.read_text(encoding="utf-8-sig")
    heading, _, rest = whole.partition("\n")
    for column in table.NEEDED:
        names = ["lost" if one == column else one for one in heading.split(",")]
        grades.write_text(",".join(names) + "\n" + rest, encoding="utf-8")
        for command in (["--merge"], [str(toy / "submitted"), "--trust-the-students"]):
            words = f"grades.csv: no column is called {column} any more; give it back"
            with pytest.raises(SystemExit, match=words):
                cli.run(cli.parse(["labs", "grade", *command, "-o", str(grades)]))


def test_the_column_of_the_totals_comes_back(grades):
    typed(grades, "3")
    text = grades.read_text(encoding="cp1252")
    grades.write_text(text.replace(";total;", ";;"), encoding="cp1252")
    assert merged(grades)[0]["total"] == "4"


@pytest.mark.parametrize("limit", ["0", "-1", "nan", "inf", "soon"])
def test_a_limit_is_a_time(limit, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["labs", "grade", "x", "--limit", limit])
    assert "is not a number of seconds above 0" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words, said",
    [
        ("grade", "name the FOLDER with what was handed in, or say --merge"),
        ("grade x --merge", "takes no FOLDER"),
        ("grade --merge --limit 5 --separator ;", "takes no --limit, --separator"),
        ("grade --merge --trust-the-students", "takes no --trust-the-students"),
        ("grade x -o grades.xlsx", "grades.xlsx: give a name that ends in .csv"),
        ("grade --merge -o grades", "grades: give a name that ends in .csv"),
        ("grade x -o ''", "the name is empty"),
        ("handout -o ''", "the name is empty"),
        ("nbgrader -o ''", "the name is empty"),
    ],
)
def test_words_that_make_no_sense_are_refused_at_once(words, said, capsys):
    with pytest.raises(SystemExit):
        cli.parse(["labs", *shlex.split(words.replace(";", "';'"))])
    assert said in capsys.readouterr().err


def test_words_that_make_sense_are_taken():
    for words in ("grade x -o a.CSV --limit 9", "grade --merge", "check x --limit 9"):
        assert cli.parse(["labs", *words.split()])


@pytest.mark.parametrize("file", ["README.md", "COURSE.md"])
def test_the_place_of_a_handout_that_is_named_is_no_refused_one(file):
    """Nor the one of the example in the help."""
    text = (ROOT / file).read_text(encoding="utf-8")
    text += (PACKAGE / "course" / "commands" / "labs.py").read_text(encoding="utf-8")
    places = re.findall(r"labs handout -o ([\w./]+)", text)
    assert len(places) == 2
    assert {(ROOT / one).resolve().parent for one in places} == {ROOT.parent}


def test_a_limit_may_be_broken(toy):
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    row = graded(toy / "submitted", toy / "grades.csv", "--limit", "9.5")["ada"]
    assert row["points"] == "3"


@pytest.mark.parametrize(
    "text, shown",
    [
        ("=1+1", "'=1+1"),
        ("-2", "-2"),
        ("-x", "'-x"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("a\x1b[2Jb\x00c", "a\ufffd[2Jb\ufffdc"),
        ("a\tb\xa0c\u3000d", "a b c d"),
        ("\t=1+1", "' =1+1"),
        ("two\nlines", "two\nlines"),
        ("\u202eevil", "\ufffdevil"),
        ("\udce9", "\ufffd"),
    ],
)
def test_text_of_students_is_harmless_in_a_table(text, shown):
    assert table.harmless(text) == shown
    assert table.harmless(shown) == shown


@pytest.mark.parametrize("text", ["PK\x03\x04" * 99, None])
def test_why_a_file_is_no_notebook_is_told_without_what_is_in_it(text, tmp_path):
    cell = nbformat.v4.new_code_cell("x = 1\n" * 99) | {"cell_type": "strange"}
    notebook = nbformat.v4.new_notebook() | {"cells": [cell]}
    hand_in(tmp_path / "lab.ipynb", text or json.dumps(notebook))
    with pytest.raises(ValueError, match="lab.ipynb is not a notebook: .*") as found:
        marks.read(tmp_path / "lab.ipynb")
    assert "PK" not in str(found.value) and "x = 1" not in str(found.value)


@pytest.mark.parametrize("title", labs())
def test_line_ends_of_windows_are_no_edit(title, tmp_path):
    lab, theirs = labs()[title], released(labs()[title])
    for cell in theirs.cells:
        cell.source = cell.source.replace("\n", "\r\n")
    nbformat.write(theirs, tmp_path / "lab.ipynb")
    assert marks.edited(lab, marks.read(tmp_path / "lab.ipynb")) == []


def test_a_mark_that_an_editor_has_put_before_a_notebook_is_no_part_of_it(tmp_path):
    text = nbformat.writes(released(TOY))
    (tmp_path / "lab.ipynb").write_text(text, encoding="utf-8-sig")
    assert len(marks.read(tmp_path / "lab.ipynb").cells) == len(released(TOY).cells)


@pytest.mark.parametrize("title", labs())
def test_given_cells_that_are_gone_are_put_back_where_they_were(title):
    lab, notebook = labs()[title], labs()[title]
    given = set(of_role(lab, "given"))
    assert given
    notebook.cells = [cell for cell in notebook.cells if name(cell) not in given]
    merged = marks.merged(lab, notebook).cells
    assert [name(cell) for cell in merged] == [name(cell) for cell in lab.cells]


def test_points_that_are_typed_while_others_are_graded_stay(grades, monkeypatch):
    folder = grades.parent / "submitted"
    hand_in(folder / "bob" / "toy.ipynb", answer(**GOOD))
    failures_of = grading.failures_of

    def meanwhile(*args, **more):
        typed(grades, "2,5")
        return failures_of(*args, **more)

    monkeypatch.setattr(grading, "failures_of", meanwhile)
    rows = graded(folder, grades)
    assert rows["ada"]["why"] == "2,5" and rows["bob"]["points"] == "3"
    assert table.separator(grades) == ";"  # as the spreadsheet saved it


def test_a_word_for_points_is_found_before_anything_is_graded(grades, monkeypatch):
    hand_in(grades.parent / "submitted" / "bob" / "toy.ipynb", answer(**GOOD))
    typed(grades, "2 pts")
    monkeypatch.setattr(grading, "failures_of", None)
    with pytest.raises(ValueError, match="ada, toy: '2 pts' in the table is not"):
        grading.grade(grades.parent / "submitted", grades, trusted=True)


@pytest.mark.parametrize(
    "words", [grading.OURS, "x\\nthe same file, byte for byte, as bob/toy.ipynb"]
)
def test_no_student_can_write_our_notes(toy, words):
    said = f"def add(a, b):\n    raise ValueError({words!r})"
    theirs = answer(**GOOD | {"add": said.replace("\\\\n", "\\n")})
    hand_in(toy / "submitted" / "eve" / "toy.ipynb", theirs)
    graded(toy / "submitted", toy / "grades.csv")
    typed(toy / "grades.csv", "2")
    row = graded(toy / "submitted", toy / "grades.csv")["eve"]
    assert row["why"] == "2" and len(row["note"].splitlines()) == 1
    assert "stops with ValueError" in page(toy / "grades.csv", "eve")


@pytest.fixture
def failed(toy, monkeypatch):
    """The table of a student whom we failed to grade, with points and a comment."""
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", answer(**GOOD))
    fail_to_grade(toy, monkeypatch)
    (row,) = table.read(toy / "grades.csv")
    row |= {"why": "2", "points": "2,5", "comment": "see me"}
    table.write(toy / "grades.csv", row, [row], ",")
    return toy / "grades.csv"


def fail_to_grade(toy, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(grading, "failures_of", None)
        trouble = grading.grade(toy / "submitted", toy / "grades.csv", trusted=True)
    assert trouble and grading.OURS in trouble[0]


def typed_in(output):
    """What was typed into the rows of a table."""
    keys = "why", "points", "comment"
    return [tuple(row[key] for key in keys) for row in table.read(output)]


def test_a_failure_of_ours_loses_nothing_that_was_typed(failed, toy, monkeypatch):
    fail_to_grade(toy, monkeypatch)
    assert typed_in(failed) == [("2", "2,5", "see me")]
    graded(toy / "submitted", failed)
    assert typed_in(failed) == [("2", "3", "see me")]
    (row,) = table.read(failed)
    assert (row["total"], row["note"]) == ("5", "")


def test_a_failed_row_whose_file_is_gone_stays_and_is_graded_when_it_is_back(
    failed, toy
):
    hand_in(toy / "submitted" / "bob" / "toy.ipynb", answer())
    (toy / "submitted" / "ada").rename(toy / "aside")
    graded(toy / "submitted", failed)
    assert typed_in(failed)[0] == ("2", "2,5", "see me")
    assert table.read(failed)[0]["state"] == "gone"
    (toy / "aside").rename(toy / "submitted" / "ada")
    graded(toy / "submitted", failed)
    assert typed_in(failed)[0] == ("2", "3", "see me")
    assert table.read(failed)[0]["note"] == ""


def test_a_failed_row_whose_file_was_handed_in_again_stays_as_an_older_one(failed, toy):
    again = answer(**GOOD | {"why": "Why?\n\nNow I know."})
    hand_in(toy / "submitted" / "ada" / "toy.ipynb", again)
    graded(toy / "submitted", failed)
    found = {row["points"]: row for row in table.read(failed)}
    assert {points: row["state"] for points, row in found.items()} == {
        "2,5": "older",
        "3": "",
    }
    assert found["3"]["note"] == pages.TYPED_ELSEWHERE
    assert ("2", "2,5", "see me") in typed_in(failed)


def test_a_failed_row_stays_where_the_next_run_is_stopped(failed, toy, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(grading._Grader, "rows", stopped)
        with pytest.raises(InterruptedError):
            grading.grade(toy / "submitted", failed, trusted=True)
    assert typed_in(failed)[0][0] == "2"
    graded(toy / "submitted", failed)
    assert typed_in(failed) == [("2", "3", "see me")]


def test_points_of_an_older_version_are_told_once_however_many_questions_there_are():
    two = released(TOY)
    two.cells.append(
        nbformat.from_dict(two.cells[-1] | {"metadata": meta("how", True, True, 1)})
    )
    old = {"student": "ada", "lab": "toy", "file": "a", "note": ""}
    old |= {"why": "1", "how": "2"}
    row = old | {"sha256": "new", "answers": "y", "why": "", "how": ""}
    grading._carry_over(row, [old | {"sha256": "", "answers": "x"}], {"toy": two})
    assert row["note"] == pages.TYPED_ELSEWHERE


def test_a_typed_sum_of_the_checks_gives_its_comma_to_the_total(grades):
    (row,) = table.read(grades)
    row |= {"points": "1,5", "check_add": "", "why": "2"}
    table.write(grades, row, [row], ";")
    (row,) = merged(grades)
    assert (row["points"], row["total"]) == ("1,5", "3,5")
    table.write(grades, row, [row | {"check_add": "0.5"}], ";")
    (row,) = merged(grades)
    assert (row["points"], row["total"]) == ("1.5", "3.5")  # the sum is ours again


def test_a_table_in_utf_16_is_to_be_saved_anew_and_not_to_be_removed(grades, toy):
    grades.write_text(grades.read_text(encoding="utf-8-sig"), encoding="utf-16")
    for command in (["--merge"], [str(toy / "submitted"), "--trust-the-students"]):
        with pytest.raises(SystemExit, match="save it as CSV in UTF-8") as caught:
            cli.run(cli.parse(["labs", "grade", *command, "-o", str(grades)]))
        assert "remove" not in str(caught.value)


def test_a_piece_that_was_made_text_is_named():
    notebook = answer(**GOOD)
    for place, kind in enumerate(("markdown", "code", "raw")):
        notebook.cells[place].cell_type = kind
    assert marks.missing(TOY, notebook) == [
        f"the cell {one} is text now and does not run: make it a cell of code again"
        for one in ("add", "six")
    ]
    assert marks.missing(TOY, answer(**GOOD)) == []
