"""OpenGL: contexts, programs and the assembly of GLSL; nothing of the scene."""
