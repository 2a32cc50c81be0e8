"""Renders the interactions of the scene with YADE's OpenGLRenderer, without a window or a display:
into a pixel buffer of EGL, with Mesa's software renderer.

Run by test_force_chains.py, with `glutInit` preloaded that asks for no display.
"""

import ctypes

import numpy as np
from yade import OpenGLRenderer

EGL_PLATFORM_SURFACELESS = 0x31DD
EGL_OPENGL_API = 0x30A2
EGL_SURFACE_TYPE, EGL_RENDERABLE_TYPE, EGL_DEPTH_SIZE, EGL_NONE = 0x3033, 0x3040, 0x3025, 0x3038
EGL_PBUFFER_BIT, EGL_OPENGL_BIT = 1, 8
EGL_WIDTH, EGL_HEIGHT = 0x3057, 0x3056
GL_COLOR_AND_DEPTH, GL_PROJECTION, GL_MODELVIEW, GL_RGB, GL_UNSIGNED_BYTE = (
    0x4100,
    0x1701,
    0x1700,
    0x1907,
    0x1401,
)

_pointer, _int = ctypes.c_void_p, ctypes.c_int


def _function(library, name, result, *arguments):
    function = getattr(library, name)
    function.restype, function.argtypes = result, arguments
    return function


def _numbers(*values):
    return (_int * len(values))(*values)


def make_context(width):
    """A current OpenGL context that draws into width x width pixels; returns the library."""
    egl = ctypes.CDLL("libEGL.so.1")
    display = _function(egl, "eglGetPlatformDisplay", _pointer, _int, _pointer, _pointer)(
        EGL_PLATFORM_SURFACELESS, None, None
    )
    assert _function(egl, "eglInitialize", _int, _pointer, _pointer, _pointer)(display, None, None)
    assert egl.eglBindAPI(EGL_OPENGL_API)
    wanted = _numbers(
        *(EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT),
        *(EGL_DEPTH_SIZE, 24, EGL_NONE),
    )
    config, number = _pointer(), _int()
    choose = _function(egl, "eglChooseConfig", _int, *(_pointer,) * 3, _int, _pointer)
    assert choose(display, wanted, ctypes.byref(config), 1, ctypes.byref(number)) and number.value
    size = _numbers(EGL_WIDTH, width, EGL_HEIGHT, width, EGL_NONE)
    surface = _function(egl, "eglCreatePbufferSurface", _pointer, *(_pointer,) * 3)(
        display, config, size
    )
    context = _function(egl, "eglCreateContext", _pointer, *(_pointer,) * 4)(
        display, config, None, None
    )
    use = _function(egl, "eglMakeCurrent", _int, *(_pointer,) * 4)
    assert use(display, surface, surface, context)
    return ctypes.CDLL("libGL.so.1")


def draw(box, width=600):
    """The forces of the present interactions as Gl1_NormPhys draws them, seen along z.

    Args:
        box (tuple): (xmin, xmax, ymin, ymax), a square [m].
        width (int): of the picture.

    Returns:
        ndarray: colours, shape (width, width, 3), the upper row first; white background.
    """
    gl = make_context(width)
    gl.glViewport(0, 0, width, width)
    _function(gl, "glClearColor", None, *(ctypes.c_float,) * 4)(1, 1, 1, 1)
    gl.glClear(GL_COLOR_AND_DEPTH)
    gl.glMatrixMode(GL_PROJECTION)
    gl.glLoadIdentity()
    _function(gl, "glOrtho", None, *(ctypes.c_double,) * 6)(*box, -1, 1)
    gl.glMatrixMode(GL_MODELVIEW)
    gl.glLoadIdentity()
    renderer = OpenGLRenderer(shape=False, bound=False, intrPhys=True, lightPos=(0, 0, 10))
    renderer.render()
    gl.glFinish()
    pixels = (ctypes.c_ubyte * (3 * width * width))()
    gl.glReadPixels(0, 0, width, width, GL_RGB, GL_UNSIGNED_BYTE, pixels)
    return np.frombuffer(pixels, np.uint8).reshape(width, width, 3)[::-1]
