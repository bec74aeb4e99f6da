"""
The decorators of compiled loops, under the name by which the planner's rooms know them.
"""

from quad_common.compiled import compiled as compiled
from quad_common.compiled import compiled_part as compiled_part
from quad_common.compiled import inlined_part as inlined_part
