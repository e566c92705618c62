"""Figures in words: what the command line lists, and what its ``NAME=VALUE`` words mean."""

from mkt import figures

SHORT = {"n": "particles"}  # as the papers call their number
ANY = "Numbers need not be one of those listed, which are the positions of a slider."


def listing(id=None):
    """The names of all figures with their titles, or the parameters of one with the positions of its sliders, as text.  Raises KeyError."""
    if id is None:
        return "\n".join(f"{entry.id:24} {entry.title}" for entry in figures.registry().values())
    entry = figures.get(id)
    rows = [f"  {name}={value}" + (f"    one of {', '.join(map(str, entry.values(name)))}" if name in entry.sliders else "")
            for name, value in entry.defaults.items()]
    return "\n".join([f"{entry.id}: {entry.title}", *rows, ANY, *(f"{short} means {name}." for short, name in _short(entry).items())])


def _short(entry):
    """{short name: parameter} as far as the figure has the parameter and no other of that name."""
    return {short: name for short, name in SHORT.items() if name in entry.defaults and short not in entry.defaults}


def parameters(entry, assignments):
    """{name: value} of an `mkt.figures.Entry` from ``name=value`` words, each value of the type of the paper's.

    Numbers need not be positions of a slider, words must.  Raises ValueError that names what is wrong.
    """
    result = {}
    for word in assignments:
        name, equals, text = word.partition("=")
        if not equals:
            raise ValueError(f"{word!r} is not NAME=VALUE")
        name = _short(entry).get(name, name)
        if name not in entry.defaults:
            known = ", ".join([*entry.defaults, *(f"{short} for {name}" for short, name in _short(entry).items())])
            raise ValueError(f"{entry.id} has no parameter {name!r}; it takes {known}")
        result[name] = _value(entry, name, text)
    return result


def _value(entry, name, text):
    known = [entry.defaults[name], *(entry.values(name) if name in entry.sliders else [])]
    kind = max(map(type, known), key=(str, bool, int, float).index)  # 5 among 2.5 and 10 is a float that was written short
    if kind in (int, float):
        return _number(name, text, kind)
    choices = {str(value): value for value in known}
    if name in entry.sliders and text not in choices:
        raise ValueError(f"{name}={text}: choose from {', '.join(map(str, entry.values(name)))}")
    return choices.get(text, text)


def _number(name, text, kind):
    try:
        return kind(text)
    except ValueError:
        raise ValueError(f"{name}={text}: not a number of type {kind.__name__}") from None
