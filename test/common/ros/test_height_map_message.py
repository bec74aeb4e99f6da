"""A height map comes through a point cloud unharmed; what is no height map is refused."""

import math
from array import array

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('sensor_msgs')

from builtin_interfaces.msg import Time
from sensor_msgs.msg import PointCloud2, PointField

from quad_common.errors import InvalidMessage
from quad_common.maps.height_map import HeightMap
from quad_common.ros.height_map_conversions import height_map_from_message, height_map_message

pytestmark = pytest.mark.ros

STAMP = Time(sec=3, nanosec=7)


def heights_of(rows=5, columns=8, resolution=0.02, origin=(-1.3, 12.4)):
    heights = np.random.default_rng(0).normal(size=(rows, columns))
    heights[1, 2] = math.nan
    return HeightMap(heights, resolution, origin)


def message_of(**sizes):
    return height_map_message(heights_of(**sizes), 'map', STAMP)


def read(message):
    return height_map_from_message(message, ('map', 'odom'))


def points_of(message):
    data = np.frombuffer(message.data, '<f4').reshape(message.height, message.width, -1)
    return data.copy()


def with_points(message, points):
    message.data = array('B', points.astype('<f4').tobytes())
    return message


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('resolution', [0.02, 0.05, 1.0 / 3.0, 2.0])
@pytest.mark.parametrize(('rows', 'columns'), [(2, 3), (5, 8), (400, 300)])
def test_a_height_map_comes_through_a_message_unharmed(rows, columns, resolution):
    heights = heights_of(rows, columns, resolution)
    again = read(height_map_message(heights, 'odom', STAMP))
    assert again.resolution == pytest.approx(resolution, abs=1e-6)
    assert again.origin == pytest.approx(heights.origin, abs=2e-6)
    assert again.heights == pytest.approx(heights.heights, abs=1e-6, nan_ok=True)
    assert again.centers == pytest.approx(heights.centers, abs=1e-4)


def test_the_message_is_an_organized_cloud_of_the_cells_centers():
    heights = heights_of()
    message = height_map_message(heights, 'map', STAMP)
    assert (message.header.frame_id, message.header.stamp) == ('map', STAMP)
    assert (message.height, message.width) == (5, 8)
    assert [(f.name, f.offset, f.datatype) for f in message.fields] == [
        ('x', 0, PointField.FLOAT32),
        ('y', 4, PointField.FLOAT32),
        ('z', 8, PointField.FLOAT32),
    ]
    assert (message.point_step, message.row_step, message.is_bigendian) == (12, 96, False)
    assert not message.is_dense
    points = points_of(message)
    assert points[2, 3, :2] == pytest.approx(heights.centers[2, 3])
    assert np.isnan(points[1, 2, 2])


def test_other_fields_padding_and_the_other_byte_order_are_read():
    message = message_of()
    points = points_of(message)
    layout = np.dtype(
        {'names': [*'xyz'], 'formats': ['>f4'] * 3, 'offsets': [4, 12, 8], 'itemsize': 20}
    )
    padded = np.zeros((5, 200), np.uint8)
    cloud = np.ndarray((5, 8), layout, padded, 0, (200, 20))
    for index, name in enumerate('xyz'):
        cloud[name] = points[..., index]
    message.fields = [
        PointField(name='intensity', offset=0, datatype=PointField.FLOAT32, count=1),
        *(
            PointField(name=name, offset=offset, datatype=PointField.FLOAT32, count=1)
            for name, offset in (('z', 8), ('x', 4), ('y', 12))
        ),
    ]
    message.is_bigendian, message.point_step, message.row_step = True, 20, 200
    message.data = array('B', padded.tobytes())
    assert read(message).heights == pytest.approx(read(message_of()).heights, nan_ok=True)


def changed(**fields):
    message = message_of()
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def in_frame(frame):
    message = message_of()
    message.header.frame_id = frame
    return message


def moved(change):
    message = message_of()
    return with_points(message, change(points_of(message)))


def shifted(points):
    points[3, 4, 0] += 0.002
    return points


def without_x(points):
    points[3, 4, 0] = math.nan
    return points


@pytest.mark.parametrize(
    ('message', 'told'),
    [
        (in_frame('base_link'), "it is in frame 'base_link'; give it in 'map'"),
        (changed(height=1, width=40), 'it must be organized'),
        (PointCloud2(header=message_of().header), '0 rows of 0 points'),
        (changed(height=10**5, width=10**5), '4194304 are the most'),
        (changed(fields=message_of().fields[:2]), "no field 'z'; its fields are x, y"),
        (
            changed(fields=[*message_of().fields[:2], PointField(name='z', offset=8, datatype=8)]),
            "its field 'z' is of type 8",
        ),
        (changed(point_step=10), "its field 'z' is of type 7, 1 of them, at byte 8 of 10"),
        (changed(data=message_of().data[:-1]), 'it has 479 bytes in rows of 96'),
        (changed(row_step=95), 'it has 480 bytes in rows of 95'),
        (moved(shifted), 'up to 0.10 cells off a square grid of 0.02 m'),
        (moved(without_x), 'x or y of a point is not finite'),
        (moved(lambda points: points[::-1]), 'cells off a square grid'),
        (moved(lambda points: points[:, ::-1]), 'x must rise along the rows'),
        (moved(lambda points: 0.0 * points), 'x must rise along the rows'),
        (moved(lambda points: points * (1.0, 2.0, 1.0)), 'cells off a square grid'),
    ],
)
def test_what_is_no_height_map_is_refused_in_a_sentence(message, told):
    with pytest.raises(InvalidMessage, match='the height map cannot be used: ') as caught:
        read(message)
    caught.match(told)
