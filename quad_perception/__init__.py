"""
Perception: from the picture of a camera under the ceiling to a map, the robot and the goal.

The robot, the obstacles and the goal differ in color (S1). Where things stand on the
floor follows from the camera's model and pose: nothing else is known about the room.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_perception.picture.camera_calibration import CameraCalibration as CameraCalibration
    from quad_perception.picture.camera_calibration import calibrate_pose as calibrate_pose
    from quad_perception.picture.color_segmentation import ColorRange as ColorRange
    from quad_perception.picture.color_segmentation import load_ranges as load_ranges
    from quad_perception.picture.perception import Perceiver as Perceiver
    from quad_perception.picture.perception import Perception as Perception
    from quad_perception.picture.scene_model import SceneModel as SceneModel
    from quad_perception.tracking.scene_tracker import SceneTracker as SceneTracker
    from quad_perception.tracking.scene_tracker import Sighting as Sighting
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_perception.picture.perception': ('Perceiver', 'Perception'),
            'quad_perception.picture.scene_model': ('SceneModel',),
            'quad_perception.picture.color_segmentation': ('ColorRange', 'load_ranges'),
            'quad_perception.picture.camera_calibration': ('CameraCalibration', 'calibrate_pose'),
            'quad_perception.tracking.scene_tracker': ('SceneTracker', 'Sighting'),
        },
    )
