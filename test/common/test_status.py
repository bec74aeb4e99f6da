"""What a node says of itself: notes make warnings, and figures alone are no news."""

from quad_common.status import Level, Status


def test_notes_are_added_and_make_a_warning_of_what_was_none():
    fine = Status(Level.OK, 'walking', {'activity': 'walking'})
    assert fine.with_notes('', '') == fine
    noted = fine.with_notes('', 'no imu', 'an old map')
    assert (noted.level, noted.message) == (Level.WARN, 'walking; no imu; an old map')
    assert noted.values == fine.values
    assert Status(Level.ERROR, 'fallen').with_notes('no imu').level is Level.ERROR


def test_statuses_that_differ_in_figures_alone_are_about_the_same():
    first = Status(Level.OK, 'walking: walking 0.209 m and turning by -4.2 degrees')
    second = Status(Level.OK, 'walking: walking 0.08 m and turning by 12.0 degrees')
    assert first.subject == second.subject
    assert first.subject != Status(Level.OK, 'turning: turning by 12.0 degrees').subject


def test_each_error_is_about_something_of_its_own():
    first, second = (Status(Level.ERROR, f'the goal ({x}, 0.00) m is outside') for x in (9, 10))
    assert first.subject != second.subject
