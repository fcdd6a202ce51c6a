"""The script of a user, whose types `make lint` checks strictly, does what it says."""

import user_script


def test_the_users_script_runs():
    assert set(user_script.main()) == {"kalman", "imm"}
