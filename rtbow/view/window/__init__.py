"""The window: a GLFW window with OpenGL, what ImGui draws in it, and what hands do to it.

Python's glfw and ImGui's own backend have to share one GLFW library. On Linux the second one to be
loaded takes the first by its soname, and glfw's own comes first, since that alone has Wayland;
elsewhere imgui_bundle points glfw to its library, if it is imported first.
"""

import sys

if sys.platform.startswith("linux"):
    import glfw  # noqa: F401
else:
    import imgui_bundle  # noqa: F401
