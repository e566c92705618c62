"""Labs: notebooks with pieces to write, visible checks that explain a failure in words, and hidden ones for the teacher.

`mkt.labs.notebooks` says what a lab is and makes the student's version, `mkt.labs.kernel` runs cells whatever they do, `mkt.labs.grading`
gives the points: to a student for one notebook, to a teacher for a folder of them.  Marks and metadata are nbgrader's, which can
generate and grade the same files.
"""
