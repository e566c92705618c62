"""Labs: notebooks with pieces to write.

They have visible checks that explain a failure in words, and hidden ones for the
teacher.  `mkt.course.labs.notebooks` says what a lab is and makes the student's
version, `mkt.course.labs.handout` all that a student needs.

Whatever is marked is marked by `mkt.course.labs.judge`, which asks a process of its own
(`mkt.course.labs.accused`, at the other end of `mkt.course.labs.student`; they send one
another `mkt.course.labs.values`), which runs in a `mkt.course.labs.sandbox`.
`mkt.course.labs.marks` says what a notebook is worth, `mkt.course.labs.checking` tells
a student, and `mkt.course.labs.grading` a teacher: it makes a `mkt.course.labs.table`
and `mkt.course.labs.pages` of `mkt.course.labs.submissions`.  Marks and metadata are
nbgrader's, which can generate and grade the same files.
"""
