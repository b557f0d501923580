import copy

import numpy as np
import pytest

from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference.memory import ObstacleMemory, cells_at
from scaloft_fi.stack.reference.messages import Clearing


@pytest.fixture
def memory(memory_config, camera):
    return ObstacleMemory(memory_config, camera)


def see(memory, frame, pose):
    clearing = memory.observe(frame, pose)
    memory.update(clearing)
    return clearing


def test_a_wall_ahead_becomes_cells_on_its_plane(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at())
    points = memory.map(pose_at()).points
    assert len(points) > 50
    assert np.all(np.abs(points[:, 0] - 2.1) <= 0.15)
    assert np.abs(points[:, 1]).max() == pytest.approx(2.0 * np.tan(1.02974 / 2), abs=0.15)


def test_a_wall_is_where_the_camera_was_turned_to(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at(x=5.0, y=-3.0, yaw=np.pi / 2))
    points = memory.map(pose_at(x=5.0, y=-3.0)).points
    assert np.all(np.abs(points[:, 1] - (-3.0 + 2.1)) <= 0.15)
    assert points[:, 0].mean() == pytest.approx(5.0, abs=0.05)


def test_a_camera_that_looks_down_sees_lower(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at(pitch=0.4))
    assert memory.map(pose_at()).points[:, 2].mean() == pytest.approx(1.5 - 2.1 * np.sin(0.4), abs=0.1)


def test_a_single_pixel_is_noise(memory, pose_at):
    depth = np.zeros((48, 64))
    depth[10, 12] = 2.0
    see(memory, DepthFrame(0.0, depth), pose_at())
    assert len(memory) == 0
    depth = depth.copy()
    depth[10, 11] = 2.0
    see(memory, DepthFrame(0.05, depth), pose_at())
    assert len(memory) == 1


@pytest.mark.parametrize("depth_m", [0.1, 5.5, 0.0, np.inf, np.nan])
def test_depths_out_of_range_mark_nothing(memory, pose_at, wall_at, depth_m):
    see(memory, wall_at(depth_m), pose_at())
    assert len(memory) == 0


@pytest.mark.parametrize("farther", [4.0, 0.0])
def test_a_frame_that_sees_through_a_wall_clears_it(memory, pose_at, wall_at, farther):
    see(memory, wall_at(2.0), pose_at())
    before = len(memory)
    clearing = see(memory, wall_at(farther, 0.05), pose_at())
    assert len(clearing.forget) >= 0.85 * before  # all but those whose centres are out of view
    points = memory.map(pose_at()).points
    assert np.sum(np.abs(points[:, 0] - 2.1) <= 0.15) == before - len(clearing.forget)


def test_what_a_nearer_wall_hides_stays(memory, pose_at, wall_at):
    see(memory, wall_at(4.0), pose_at())
    far = len(memory)
    clearing = see(memory, wall_at(2.0, 0.05), pose_at())
    assert len(clearing.forget) == 0
    assert len(memory) > far


def test_what_is_out_of_view_stays_until_it_is_too_old(memory, pose_at, wall_at):
    see(memory, wall_at(2.0, 0.0), pose_at())
    wall = set(memory.observe(wall_at(2.0, 0.0), pose_at()).occupied.tolist())
    assert len(see(memory, wall_at(0.0, 19.9), pose_at(yaw=np.pi)).forget) == 0
    clearing = see(memory, wall_at(0.0, 20.1), pose_at(yaw=np.pi))
    assert set(clearing.forget.tolist()) == wall
    assert len(memory) == 0


def test_a_wall_seen_again_is_young_again(memory, pose_at, wall_at):
    see(memory, wall_at(2.0, 0.0), pose_at())
    see(memory, wall_at(2.0, 15.0), pose_at())
    assert len(see(memory, wall_at(0.0, 30.0), pose_at(yaw=np.pi)).forget) == 0


def test_what_is_not_delivered_is_not_forgotten(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at())
    before = len(memory)
    memory.observe(wall_at(0.0, 0.05), pose_at())
    memory.update(None)
    assert len(memory) == before


def test_what_is_delivered_is_forgotten_and_what_is_seen_comes_back(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at())
    before = len(memory)
    clearing = memory.observe(wall_at(2.0, 0.05), pose_at())
    assert len(clearing.forget) == 0
    memory.update(clearing._replace(forget=clearing.occupied))
    assert len(memory) == before
    memory.observe(wall_at(0.0, 0.1), pose_at(yaw=np.pi))
    memory.update(Clearing(0.1, clearing.occupied, clearing.occupied))
    assert len(memory) == 0


def test_the_order_of_what_is_delivered_does_not_matter(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at())
    other = copy.deepcopy(memory)
    for copied, order in ((memory, slice(None)), (other, slice(None, None, -1))):
        clearing = copied.observe(wall_at(4.0, 0.05), pose_at())
        some = np.append(clearing.forget[::2], cells_at(np.array([[50.0, 50.0, 50.0]]), 0.15))
        copied.update(clearing._replace(forget=some[order].copy()))
    assert np.array_equal(memory.map(pose_at()).points, other.map(pose_at()).points)


def test_an_update_without_a_frame_changes_nothing(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at())
    before = memory.map(pose_at()).points
    memory.update(None)
    assert np.array_equal(memory.map(pose_at()).points, before)


def test_a_sent_message_never_changes(memory, pose_at, wall_at):
    see(memory, wall_at(2.0), pose_at())
    clearing, told = memory.observe(wall_at(3.0, 0.05), pose_at()), memory.map(pose_at())
    copies = [a.copy() for a in (clearing.forget, clearing.occupied, told.points)]
    memory.update(clearing)
    see(memory, wall_at(0.0, 0.1), pose_at())
    for now, then in zip((clearing.forget, clearing.occupied, told.points), copies, strict=True):
        assert np.array_equal(now, then)


def test_the_map_holds_what_is_near_and_the_newest_frames_stamp(memory, memory_config, pose_at, wall_at):
    assert memory.map(pose_at()).stamp_s == -np.inf
    see(memory, wall_at(4.0, 7.5), pose_at())
    told = memory.map(pose_at(x=-3.0))
    assert told.stamp_s == 7.5
    assert told.inflation == 1.0
    assert np.all(np.linalg.norm(told.points - [-3.0, 0.0, 1.5], axis=1) < memory_config.local_radius_m)
    assert len(memory.map(pose_at(x=-9.0)).points) == 0


def test_a_mirrored_view_of_an_image_is_an_image(memory, pose_at):
    depth = np.zeros((48, 64))
    depth[20:28, 2:8] = 2.0
    see(memory, DepthFrame(0.0, depth[:, ::-1]), pose_at())
    assert np.all(memory.map(pose_at()).points[:, 1] < 0)


@pytest.mark.parametrize("x", [np.nan, np.inf, 1e300])
def test_a_diverged_estimate_marks_nothing_and_clears_nothing(memory, pose_at, wall_at, x):
    see(memory, wall_at(2.0), pose_at())
    before = memory.map(pose_at()).points
    see(memory, wall_at(2.0, 0.05), pose_at(x=x))
    assert np.array_equal(memory.map(pose_at()).points, before)
    assert len(memory.map(pose_at(x=x)).points) == 0


def test_copies_go_on_alike_and_apart(memory, pose_at):
    rng = np.random.default_rng(1)
    frames = [DepthFrame(i / 20, rng.uniform(0.2, 6.0, (48, 64))) for i in range(12)]
    for i, frame in enumerate(frames[:6]):
        see(memory, frame, pose_at(yaw=0.2 * i))
    twin = copy.deepcopy(memory)
    for i, frame in enumerate(frames[6:]):
        see(memory, frame, pose_at(yaw=0.2 * i))
    assert len(twin) != len(memory)
    for i, frame in enumerate(frames[6:]):
        see(twin, frame, pose_at(yaw=0.2 * i))
    assert np.array_equal(twin.map(pose_at()).points, memory.map(pose_at()).points)


class SlowMemory:
    """The same memory, a cell and a pixel at a time."""

    def __init__(self, config, camera):
        self.config, self.camera, self.seen = config, camera, {}

    def observe(self, frame, rotation, position):
        c, depth = self.config, frame.depth
        eye = position + rotation @ [self.camera.ahead_m, 0.0, 0.0]
        count = {}
        for r, k in np.ndindex(*depth.shape):
            if c.min_range_m <= depth[r, k] <= c.max_range_m:
                point = eye + rotation @ (self.camera.rays[r, k] * depth[r, k])
                cell = int(cells_at(point[None], c.voxel_m)[0])
                count[cell] = count.get(cell, 0) + 1
        fresh = {cell for cell, n in count.items() if n >= c.min_pixels}
        forget = {
            cell
            for cell, (when, centre) in self.seen.items()
            if cell not in fresh
            and (when < frame.stamp_s - c.max_age_s or self._through(rotation.T @ (centre - eye), depth))
        }
        for cell in forget:
            del self.seen[cell]
        for r, k in np.ndindex(*depth.shape):
            point = eye + rotation @ (self.camera.rays[r, k] * depth[r, k])
            if int(cells_at(point[None], c.voxel_m)[0]) in fresh:
                cell = int(cells_at(point[None], c.voxel_m)[0])
                self.seen[cell] = (frame.stamp_s, (np.floor(point / c.voxel_m) + 0.5) * c.voxel_m)
        return forget

    def _through(self, centre, depth):
        c, camera = self.config, self.camera
        if not c.min_range_m < centre[0] < c.max_range_m:
            return False
        k = (centre[1] / centre[0] - camera.column[0]) / camera.column[1]
        r = (centre[2] / centre[0] - camera.row[0]) / camera.row[1]
        k, r = int(np.floor(k + 0.5)), int(np.floor(r + 0.5))
        if not (0 <= k < depth.shape[1] and 0 <= r < depth.shape[0]):
            return False
        return bool(depth[r, k] == 0.0 or depth[r, k] > centre[0] + c.clear_margin_m)


def rotation_of(q):
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize("seed", range(3))
def test_the_memory_equals_a_slow_one(memory, memory_config, camera, pose_at, seed):
    rng = np.random.default_rng(seed)
    slow = SlowMemory(memory_config, camera)
    for i in range(6):
        blocks = np.kron(rng.uniform(0.2, 5.5, (6, 8)), np.ones((8, 8)))
        depth = np.where(rng.random(blocks.shape) < 0.1, 0.0, blocks + rng.normal(0, 0.02, blocks.shape))
        pose = pose_at(*rng.uniform(-1, 1, 3), yaw=rng.uniform(-3, 3) * (i % 2), pitch=rng.uniform(-0.3, 0.3))
        frame = DepthFrame(4.5 * i, depth)
        clearing = see(memory, frame, pose)
        assert set(clearing.forget.tolist()) == slow.observe(frame, rotation_of(pose.attitude), pose.position)
        occupied = memory.observe(frame, pose).occupied.tolist()
        memory.update(None)
        assert sorted(occupied) == sorted(slow.seen)
        assert len(set(occupied)) == len(occupied)
