"""``doctor`` says what is wrong with this machine."""

from mkt.course.commands import Commands, command


def add(commands: Commands) -> None:
    """Describe the command."""
    command(
        commands,
        "doctor",
        run,
        "say what is wrong with this machine",
        "Looks at Python, the environment, its packages, video formats, JupyterLab's\n"
        "widgets and data sets, and says how to mend what is wrong.",
    )


def run(args) -> int:
    """Print what is wrong and how to mend it: exit code 1 where something is."""
    from mkt.course import doctor

    return doctor.main()
