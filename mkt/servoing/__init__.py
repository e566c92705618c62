"""Visual servoing, Section VI of [T09]: a robot's camera follows what is tracked.

In reading order: image features (`features`), the control law (`law`), the target's own
motion (`self_motion`), the loop's poles (`poles`), a simulated robot (`robot`), the
controller (`controller`), and the loop through them all (`loop`); and what a whole
plane tells (`planes`).
"""
