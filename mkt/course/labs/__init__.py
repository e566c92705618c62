"""Labs: notebooks with pieces to write.

They have visible checks that explain a failure in words, and hidden ones for the
teacher.  `mkt.course.labs.notebooks` says what a lab is and makes the student's
version, `mkt.course.labs.process` runs cells whatever they do, `mkt.course.labs.marks`
says what a notebook is worth, `mkt.course.labs.grading` says so to a student for one
notebook, and to a teacher for a folder of `mkt.course.labs.submissions`.  Marks and
metadata are nbgrader's, which can generate and grade the same files.
"""
