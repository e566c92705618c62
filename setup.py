"""What pyproject.toml cannot say: the folder data/ is installed as ``mkt/data``."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["mkt*"]), "mkt.data"],
    package_dir={"mkt.data": "data"},
)
