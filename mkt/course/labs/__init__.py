"""Labs: notebooks with pieces to write.

They have visible checks that explain a failure in words, and hidden ones for the
teacher.  `mkt.course.labs.notebooks` says what a lab is and makes the student's
version, `mkt.course.labs.handout` all that a student needs, and
`mkt.course.labs.variants` gives each a scene of their own.

All marks come from `mkt.course.labs.judge`.  It runs the student's code in another
process, `mkt.course.labs.accused`, inside a `mkt.course.labs.sandbox`.  It speaks to
that process through `mkt.course.labs.student`; what they send one another are
`mkt.course.labs.values`.  `mkt.course.labs.marks` says what a notebook is worth,
`mkt.course.labs.checking` tells a student, and `mkt.course.labs.grading` a teacher: it
makes a `mkt.course.labs.table` with `mkt.course.labs.sums`, and `mkt.course.labs.pages`
of `mkt.course.labs.submissions`.  Notes are on what is `mkt.course.labs.borrowed`, or
`mkt.course.labs.alike` in two files; `mkt.course.labs.source` reads code that nobody
runs.  Checks that need a right piece have it from `mkt.course.labs.pieces`.  Marks and
metadata are nbgrader's, which can generate and grade the same files.
"""

LIMIT = 60  # [s] that a cell or a check may take, where nobody says another
