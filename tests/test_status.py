"""One list of status codes: the engine's and Python's agree by name and number."""

import jink
from jink._engine import native


def test_the_engine_and_python_name_the_same_numbers():
    engine = {member.name: member.value for member in native.Status}
    assert engine == {name: int(member) for name, member in jink.Status.__members__.items()}
