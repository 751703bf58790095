"""Generated heads: sound meshes, different people, and faces that OpenCV's stock detector recognises as such."""

from dataclasses import replace

import cv2
import mujoco
import numpy as np
import pytest

from jointattn_mj.errors import ConfigError
from jointattn_mj.scene.face import IDENTITIES, FaceConfig, build_face, identity
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH, SceneConfig, build_model

pytestmark = pytest.mark.integration

# Detector parameters at the image's own size: a face is about 28 x 40 px, the cascade's window 24 px.
SCALE, NEIGHBOURS, SMALLEST = 1.1, 3, (24, 24)


def looks(model, data, renderer, yaw, pitch, gaze=(0.0, 0.0)):
    """Gray image of the robot's eye with the caregiver's head and eyes turned so (degrees)."""
    data.joint("caregiver/neck_yaw").qpos, data.joint("caregiver/neck_pitch").qpos = np.radians((yaw, pitch))
    for side in ("left", "right"):
        data.joint(f"caregiver/eye_{side}_yaw").qpos = np.radians(gaze[0])
        data.joint(f"caregiver/eye_{side}_pitch").qpos = np.radians(gaze[1])
    mujoco.mj_forward(model, data)
    renderer.update_scene(data, "robot/eye")
    return cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2GRAY)


def haar_rate(name, yaws, pitches, gazes):
    """Fraction of poses in which the frontal cascade finds the face, and the number of finds elsewhere."""
    cascade = cv2.CascadeClassifier(cv2.data.haarcascades + "haarcascade_frontalface_default.xml")
    model = build_model(SceneConfig(caregiver=name))
    data = mujoco.MjData(model)
    found, wrong, total = 0, 0, 0
    with mujoco.Renderer(model, IMAGE_HEIGHT, IMAGE_WIDTH) as renderer:
        for yaw in yaws:
            for pitch in pitches:
                for gaze in gazes:
                    gray = looks(model, data, renderer, yaw, pitch, gaze)
                    boxes = cascade.detectMultiScale(gray, SCALE, NEIGHBOURS, minSize=SMALLEST)
                    hits = [
                        abs(x + w / 2 - 159.5) < 0.3 * w < 15 and abs(y + h / 2 - 105.3) < 0.3 * h
                        for x, y, w, h in boxes
                    ]
                    found, wrong, total = found + any(hits), wrong + len(hits) - sum(hits), total + 1
    return found / total, wrong


@pytest.mark.parametrize("name", list(IDENTITIES))
def test_haar_cascade_finds_near_frontal_faces(name):
    rate, wrong = haar_rate(name, np.linspace(-20, 20, 5), np.linspace(-15, 15, 4), [(3.0, -4.0)])
    assert rate >= 0.95
    assert wrong == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", list(IDENTITIES))
def test_haar_cascade_finds_near_frontal_faces_on_the_full_grid(name):
    gazes = [(0.0, 0.0), (4.0, -3.0), (-4.0, 5.0), (6.0, 8.0), (-6.0, 2.0)]
    rate, wrong = haar_rate(name, np.linspace(-20, 20, 11), np.linspace(-15, 15, 7), gazes)
    assert rate >= 0.95
    assert wrong == 0


@pytest.mark.parametrize("name", list(IDENTITIES))
@pytest.mark.parametrize("detail", [1, 3])
def test_mesh_is_sound(name, detail):
    face = build_face(IDENTITIES[name], detail, 64)
    assert face.faces.max() < len(face.vertices) == len(face.uv) == len(face.normals)
    assert np.isfinite(face.vertices).all() and np.isfinite(face.normals).all()
    assert face.uv.min() >= 0 and face.uv.max() <= 1
    np.testing.assert_allclose(np.linalg.norm(face.normals, axis=1), 1, atol=1e-6)
    assert face.texture.shape == (64, 64, 3) and face.texture.dtype == np.uint8
    size = np.ptp(face.vertices, axis=0)
    assert 0.15 < size[1] < 0.24 and 0.22 < size[2] < 0.29  # an adult's head with hair, metres
    # Outside is outside: normals on the front of the face point forwards.
    front = (face.vertices[:, 0] > 0.06) & (np.abs(face.vertices[:, 1]) < 0.02) & (face.vertices[:, 2] > 0.03)
    assert (face.normals[front, 0] > 0).all()


def test_detail_of_the_closed_loop_is_small():
    for config in IDENTITIES.values():
        assert len(build_face(config).faces) < 1700


def test_eyes_fill_the_lids():
    """From in front, every eye shows a ball of its own geom between the lids."""
    for name in IDENTITIES:
        model = build_model(SceneConfig(caregiver=name))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        with mujoco.Renderer(model, IMAGE_HEIGHT, IMAGE_WIDTH) as renderer:
            renderer.enable_segmentation_rendering()
            close = mujoco.MjvCamera()
            close.lookat, close.distance, close.azimuth, close.elevation = (1.5, 0, 1.08), 0.35, 0, 0
            renderer.update_scene(data, close)
            geom = renderer.render()[..., 0]
        for side in ("left", "right"):
            assert 100 < (geom == model.geom(f"caregiver/eye_{side}").id).sum() < 2000, (name, side)


def test_people_differ_and_are_deterministic():
    textures = {name: build_face(config).texture.astype(float) for name, config in IDENTITIES.items()}
    for a in textures:
        np.testing.assert_array_equal(textures[a], build_face(IDENTITIES[a]).texture)
        for b in textures:
            assert a == b or np.abs(textures[a] - textures[b]).mean() > 8
    assert len(IDENTITIES) >= 4


def test_seed_varies_skin_a_little():
    base = FaceConfig()
    first, other = build_face(base).texture.astype(float), build_face(replace(base, seed=9)).texture.astype(float)
    assert 0.2 < np.abs(first - other).mean() < 15


def test_any_face_is_a_config_value():
    face = FaceConfig(skin=(0.7, 0.5, 0.4), hair=(0.1, 0.1, 0.1), hair_style="bun", width=1.05, length=0.95, seed=4)
    model = build_model(SceneConfig(face=face))
    assert model.mesh("caregiver/head").vertnum[0] == len(build_face(face).vertices)


def test_pose_changes_the_image_gradually():
    """Views of the face are alike for small turns and unlike for large ones: what template matching needs."""
    model = build_model()
    data = mujoco.MjData(model)
    with mujoco.Renderer(model, IMAGE_HEIGHT, IMAGE_WIDTH) as renderer:

        def patch(yaw, pitch):
            return looks(model, data, renderer, yaw, pitch)[85:127, 142:178].copy()

        frontal = patch(0, 15)

        def similarity(yaw, pitch):
            return cv2.matchTemplate(patch(yaw, pitch), frontal, cv2.TM_CCOEFF_NORMED)[0, 0]

        scores = [similarity(yaw, 15) for yaw in (4, 12, 24, 40)]
        assert all(np.diff(scores) < 0) and scores[0] > 0.9 and scores[-1] < 0.7
        scores = [similarity(0, pitch) for pitch in (18, 25, 40)]
        assert all(np.diff(scores) < 0) and scores[0] > 0.9


@pytest.mark.parametrize("options", [{"hair_style": "mohawk"}, {"skin": (300, 0, 0)}, {"nose": 9.0}])
def test_bad_faces_are_named(options):
    with pytest.raises(ConfigError, match=next(iter(options))):
        FaceConfig(**options)


def test_unknown_person_is_named_with_the_known_ones():
    with pytest.raises(ConfigError, match="robin"):
        identity("nobody")
