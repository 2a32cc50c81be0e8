"""Renders the scene with YADE's OpenGLRenderer, without a window or a display: into a pixel buffer
of EGL, with Mesa's software renderer.

For processes started in an environment changed by :func:`without_display`.
"""

import ctypes
import subprocess

import numpy as np
from yade import OpenGLRenderer

EGL_PLATFORM_SURFACELESS = 0x31DD
EGL_OPENGL_API = 0x30A2
EGL_SURFACE_TYPE, EGL_RENDERABLE_TYPE, EGL_DEPTH_SIZE, EGL_NONE = 0x3033, 0x3040, 0x3025, 0x3038
EGL_PBUFFER_BIT, EGL_OPENGL_BIT = 1, 8
EGL_WIDTH, EGL_HEIGHT = 0x3057, 0x3056
GL_COLOR_AND_DEPTH, GL_DEPTH_TEST, GL_PROJECTION, GL_MODELVIEW, GL_RGB, GL_UNSIGNED_BYTE = (
    0x4100,
    0x0B71,
    0x1701,
    0x1700,
    0x1907,
    0x1401,
)

#: freeglut would end the process where there is no display; the renderer uses nothing of it here.
NO_GLUT = "void glutInit(int* count, char** words) { (void)count; (void)words; }"

_pointer, _int = ctypes.c_void_p, ctypes.c_int


def _function(library, name, result, *arguments):
    function = getattr(library, name)
    function.restype, function.argtypes = result, arguments
    return function


def _numbers(*values):
    return (_int * len(values))(*values)


def without_display(folder):
    """Environment in which a process renders; `folder` is for what has to be loaded into it."""
    source, library = folder / "glut.c", folder / "glut.so"
    source.write_text(NO_GLUT)
    subprocess.run(["gcc", "-shared", "-fPIC", source, "-o", library], check=True)
    return {"LD_PRELOAD": str(library), "LIBGL_ALWAYS_SOFTWARE": "1"}


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


class Canvas:
    """Pixels that scenes are drawn into, seen along z."""

    def __init__(self, box, width=600):
        """
        Args:
            box (tuple): (xmin, xmax, ymin, ymax), a square about the origin of z [m].
            width (int): of the picture.
        """
        self._gl, self._box, self._width = make_context(width), box, width
        self._renderer = OpenGLRenderer(bound=False, lightPos=(0, 0, 10))

    def draw(self, **shown):
        """The scene as it is now, on white.

        Args:
            shown: attributes of OpenGLRenderer: bodies (shape), their edges (wire), and
                interactions (intrPhys) if asked for.

        Returns:
            ndarray: colours, shape (width, width, 3), the upper row first.
        """
        gl, width = self._gl, self._width
        depth = self._box[1] - self._box[0]
        gl.glEnable(GL_DEPTH_TEST)  # as a viewer does
        gl.glViewport(0, 0, width, width)
        _function(gl, "glClearColor", None, *(ctypes.c_float,) * 4)(1, 1, 1, 1)
        gl.glClear(GL_COLOR_AND_DEPTH)
        gl.glMatrixMode(GL_PROJECTION)
        gl.glLoadIdentity()
        _function(gl, "glOrtho", None, *(ctypes.c_double,) * 6)(*self._box, -depth, depth)
        gl.glMatrixMode(GL_MODELVIEW)
        gl.glLoadIdentity()
        for name in ("shape", "wire", "intrPhys"):
            setattr(self._renderer, name, shown.get(name, False))
        self._renderer.render()
        gl.glFinish()
        pixels = (ctypes.c_ubyte * (3 * width * width))()
        gl.glReadPixels(0, 0, width, width, GL_RGB, GL_UNSIGNED_BYTE, pixels)
        return np.frombuffer(pixels, np.uint8).reshape(width, width, 3)[::-1].copy()
