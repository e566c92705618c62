"""``lab`` opens JupyterLab on the notebooks."""

from mkt.course.commands import Commands, command
from mkt.files import PACKAGE, ROOT

NOTEBOOKS = ROOT / "notebooks"
SETTINGS = PACKAGE / "course" / "jupyterlab"


def add(commands: Commands) -> None:
    """Describe the command."""
    parser = command(
        commands,
        "lab",
        run,
        "open the notebooks in JupyterLab",
        "Opens JupyterLab on the folder notebooks/ in your browser; Ctrl-C ends it.\n"
        "Everything after `lab` is handed to it.",
        "lab",
        "lab --no-browser --port 9000",
    )
    parser.usage = "python3 -m mkt lab [-h] [JUPYTERLAB ARGUMENT ...]"


def run(args) -> int | None:
    """Open JupyterLab on the notebooks, with our settings: it does not ask for news."""
    from jupyterlab.labapp import main

    ours = [
        f"--ServerApp.root_dir={NOTEBOOKS}",
        f"--LabApp.app_settings_dir={SETTINGS}",
    ]
    return main([*ours, *args.rest])
