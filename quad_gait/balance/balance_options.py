"""
Gains and times of a trot that keeps its balance.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class EstimateOptions:
    """How the velocity of a body is estimated."""

    leg_gain: float = 0.5
    """Part of the difference to what the feet say that is made up at each measurement."""
    bias_gain: float = 40.0
    """Gain with which a bias of the accelerometer is learned [1/s^2]."""
    largest_bias: float = 2.0
    """Bias, at most [m/s^2]."""
    least_load: float = 0.06
    """Load from which on a foot counts, as a fraction of the robot's weight."""
    touching_load: float = 0.3
    """Load from which on a foot that swings has met the ground, as a fraction of the weight: with
    half of it a leg that is lifted high and fast feels like ground."""
    slip_fraction: float = 0.05
    """Difference, as a fraction of sqrt(g h), at which feet that may slip count half."""
    fastest: float = 2.0
    """Velocity, as a fraction of sqrt(g h), beyond which odometry does not go by the estimate."""
    slope_memory: float = 3.0
    """Time over which the ground's gradient is estimated, in units of sqrt(h / g)."""
    slope_fraction: float = 1.0
    """Fraction of the ground's tilt that the body takes: 0 stays level, 1 goes along."""
    upright: float = 0.1
    """Tilt off the ground's up to which a body counts as one that nothing has pushed over [rad]."""
    longest_gap: float = 0.1
    """Time between two measurements, at most; after a longer one the body is taken to rest [s]."""


@dataclass(frozen=True)
class BalanceOptions:
    """How a robot trots and keeps its balance; the same for all robots."""

    knot_time: float = 0.02
    """Time between two knots of a trajectory, and between two decisions at least [s]."""
    longest_swing: float = 1.196
    """Time that a foot swings, at most, in units of sqrt(h / g): the body falls about the others
    meanwhile, and gaits that are slower are walked with shorter cycles."""
    reaction_time: float = 0.02
    """Time after a measurement for which what was given out before holds: messages arrive in it,
    and the tilt is predicted over it [s]."""
    knots: int = 6
    """Number of knots after it that answer to the measurement; the rest brings the robot to
    rest."""
    rest_knot_time: float = 0.04
    """Time between two knots of that rest [s]."""
    capture_gain: float = 1.0
    """Part of the step to the capture point that is made."""
    giving_way: float = 0.8
    """Part of an error of the velocity that standing legs give way to."""
    turn_giving_way: float = 0.7
    """Part of an error of the turn that they give way to."""
    leveling: float = 0.8
    """Part of the body's tilt that swinging feet make up for."""
    large_tilt_leveling: float = 0.72
    """The same of a large tilt: more of it, late, rocks the body."""
    low_leveling: float = 0.34
    """Part by which that is more for feet that cannot be lifted at all: the lower they are lifted,
    the sooner they meet the ground under a tilted body."""
    low_lift: float = 0.085
    """Height to which feet are lifted, over that of the center of mass, below which it is low."""
    late_leveling: float = 0.6
    """Part of all that which is left where answers take effect after the time of two decisions, not
    one: what is made up for too late rocks the body."""
    late_capture: float = 0.7
    """Part of the step to the capture point which is left there: it would overshoot."""
    small_tilt: float = 0.05
    """Tilt up to which it is the former [rad]."""
    large_tilt: float = 0.175
    """Tilt from which on it is the latter [rad]."""
    righting: float = 0.5
    """Time constant with which a leg that has landed rights the body, over the duration of a
    stance."""
    trim_gain: float = 1.2
    """Gain of the trim of the velocity, which makes its mean the one that is wanted [1/s]."""
    upright_gain: float = 0.2
    """Gain with which legs are set so that the body has no tilt in the mean [1/s]."""
    largest_upright: float = 0.03
    """Angle by which they are, at most [rad]."""
    sway_gain: float = 0.5
    """Gain with which the sway of each cycle is learned, to which standing legs give way [1/s]."""
    sway_fading: float = 0.1
    """Part of it that is forgotten in a second [1/s]."""
    largest_trim: float = 0.3
    """Trim, at most, as a fraction of sqrt(g h)."""
    pushed: float = 0.3
    """Error of the velocity from which on a robot is pushed and the trim waits, as a fraction of
    sqrt(g h)."""
    steady: float = 0.05
    """Change of what is wanted from which on the trim waits, as a fraction of sqrt(g h)."""
    acceleration: float = 0.18
    """Acceleration to what is wanted, at most, as a fraction of g."""
    gathering: float = 0.16
    """Acceleration with which plans are followed, as a fraction of g."""
    slowing: float = 0.15
    """Deceleration to rest of a robot that receives nothing more, as a fraction of g."""
    turn_acceleration: float = 4.0
    """Acceleration of turns [rad/s^2]."""
    course_gain: float = 1.5
    """Gain with which the robot is drawn back to its course [1/s]."""
    largest_correction: float = 0.15
    """Velocity with which it is, at most, as a fraction of sqrt(g h)."""
    landing_fraction: float = 0.2
    """Fraction of its swing, at its end, in which a foot follows the ground as it comes down, at
    most: as much as the joints' speeds leave of it."""
    speed_kept: float = 0.15
    """Fraction of the joints' speeds that no swing is to need, so that feet can be elsewhere."""
    steady_speed: float = 0.54
    """Fraction of the joints' speeds, from knot to knot, that a steady trot may need; the rest, up
    to ``speed_fraction``, is for corrections."""
    lift_speed: float = 0.45
    """Fraction of the joints' speeds that lifting a foot may need: slow joints lift feet lower than
    the gait has it."""
    rough_lift_speed: float = 0.75
    """The same on rough ground, where robots are slower than they could be."""
    rough: float = 0.3
    """Height by which feet are off the plane of the ground from which on they are lifted higher,
    over that to which the gait lifts them; on level ground it is less."""
    rough_lift: float = 4.0
    """Height by which feet are lifted more, over that by which ground is rougher: between the
    places on which feet have stood it may be higher."""
    highest_lift: float = 2.5
    """Height to which they are lifted at most, over the usual one."""
    touching_phase: float = 0.45
    """Fraction of its swing from which on a foot may meet the ground before its time."""
    easing: float = 0.07
    """Fraction of its swing in which a foot gathers its speed upward, and again loses it."""
    freeze_time: float = 0.03
    """Time before its touchdown from which on a foot keeps its target [s]."""
    reach_fraction: float = 1.5
    """Distance from its neutral place at which a foot is put, at most, over half of the largest
    stride."""
    reach_speed: float = 0.55
    """The same over the duration of its swing, as a fraction of sqrt(g h): legs that swing fast
    push the body."""
    speed_fraction: float = 0.95
    """Fraction of their largest speeds that joints use at most where feet are wanted sooner than
    they can be there."""
    leaning_time: float = 0.1
    """Time constant with which a robot that begins to trot on a slope first leans uphill [s]."""
    leaning: float = 5.0
    """Time for which it does, in units of that."""
    steps_in_place: bool = False
    """Whether a robot that is steered with no velocity trots in place, and does not stand."""
    estimate: EstimateOptions = field(default_factory=EstimateOptions)
    """How the velocity is estimated."""
