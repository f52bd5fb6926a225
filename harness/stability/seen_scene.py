"""The frame of a scene file that a test makes: a camera that sees what is put before it."""

SCENE = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="{fov:.9g}"/>
        <float name="near_clip" value="{near:.9g}"/>
        <float name="far_clip" value="{far:.9g}"/>
        <transform name="to_world">
            <lookat origin="{origin}" target="{target}" up="{up}"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="{size}"/>
            <integer name="height" value="{size}"/>
            <rfilter type="box"/>
        </film>
    </sensor>
{body}</scene>
"""


def scene_text(
    body: str, *, fov: float, clips: tuple[float, float], view: tuple[str, str, str], size: int
) -> str:
    """Write a scene for Mitsuba's reader.

    Parameters
    ----------
    body
        Shapes and emitters.
    fov
        Width of the image, degrees.
    clips
        Distances of the near and of the far plane.
    view
        Where the eye is, what it looks at, and what is up: coordinates with as many digits as they
        need.
    size
        Width and height of the image, in pixels.
    """
    (near, far), (origin, target, up) = clips, view
    return SCENE.format(
        fov=fov, near=near, far=far, origin=origin, target=target, up=up, size=size, body=body
    )
