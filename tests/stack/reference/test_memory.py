import copy

import numpy as np
import pytest

from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference.memory import ObstacleMemory, cells_at
from tests.sim.conftest import turned_by
from tests.stack.conftest import pose_at, wall_at


@pytest.fixture
def memory(config, camera):
    return ObstacleMemory(config.memory, camera)


def see(memory, frame, pose=None):
    clearing = memory.observe(frame, pose or pose_at())
    memory.update(clearing)
    return clearing


def points(memory, **pose):
    return memory.map(pose_at(**pose)).points


def test_a_wall_is_where_the_camera_was_turned_to(memory):
    see(memory, wall_at(2.0), pose_at(x=5.0, y=-3.0, yaw=np.pi / 2))
    seen = points(memory, x=5.0, y=-3.0)
    assert len(seen) > 50
    assert np.all(np.abs(seen[:, 1] - (-3.0 + 2.1)) <= 0.15)
    assert np.abs(seen[:, 0] - 5.0).max() == pytest.approx(2.0 * np.tan(1.02974 / 2), abs=0.15)


@pytest.mark.parametrize("depth_m", [0.1, 5.5, 0.0, np.inf, np.nan])
def test_depths_out_of_range_mark_nothing(memory, depth_m):
    see(memory, wall_at(depth_m))
    assert len(memory) == 0


@pytest.mark.parametrize("farther", [4.0, 0.0])
def test_a_frame_that_sees_through_a_wall_clears_it(memory, farther):
    see(memory, wall_at(2.0))
    before = len(memory)
    clearing = see(memory, wall_at(farther, 0.05))
    assert len(clearing.forget) >= 0.85 * before  # all but those whose centres are out of view
    assert np.sum(np.abs(points(memory)[:, 0] - 2.1) <= 0.15) == before - len(clearing.forget)


def test_what_is_out_of_view_stays_until_it_is_too_old(memory):
    see(memory, wall_at(2.0, 0.0))
    wall = memory.observe(wall_at(2.0, 0.0), pose_at()).occupied
    assert len(see(memory, wall_at(0.0, 19.9), pose_at(yaw=np.pi)).forget) == 0
    assert np.array_equal(see(memory, wall_at(0.0, 20.1), pose_at(yaw=np.pi)).forget, wall)
    assert len(memory) == 0


def test_what_is_delivered_is_forgotten_nothing_else_and_what_is_seen_comes_back(memory):
    see(memory, wall_at(2.0))
    before = points(memory)
    memory.update(None)
    memory.observe(wall_at(0.0, 0.05), pose_at())
    memory.update(None)
    assert np.array_equal(points(memory), before)
    clearing = memory.observe(wall_at(2.0, 0.05), pose_at())
    memory.update(clearing._replace(forget=clearing.occupied))
    assert len(memory) == len(before)
    memory.observe(wall_at(0.0, 0.1), pose_at(yaw=np.pi))
    memory.update(clearing._replace(forget=clearing.occupied))
    assert len(memory) == 0


def test_the_order_of_what_is_delivered_does_not_matter(memory):
    see(memory, wall_at(2.0))
    other = copy.deepcopy(memory)
    for copied, order in ((memory, slice(None)), (other, slice(None, None, -1))):
        clearing = copied.observe(wall_at(4.0, 0.05), pose_at())
        some = np.append(clearing.forget[::2], cells_at(np.array([[50.0, 50.0, 50.0]]), 0.15))
        copied.update(clearing._replace(forget=some[order].copy()))
    assert np.array_equal(points(memory), points(other))


def test_a_sent_message_never_changes(memory):
    see(memory, wall_at(2.0))
    clearing, told = memory.observe(wall_at(3.0, 0.05), pose_at()), memory.map(pose_at())
    copies = [a.copy() for a in (clearing.forget, clearing.occupied, told.points)]
    memory.update(clearing)
    see(memory, wall_at(0.0, 0.1))
    for now, then in zip((clearing.forget, clearing.occupied, told.points), copies, strict=True):
        assert np.array_equal(now, then)


def test_the_map_holds_what_is_near_and_the_newest_frames_stamp(memory, config):
    assert memory.map(pose_at()).stamp_s == -np.inf
    see(memory, wall_at(4.0, 7.5))
    told = memory.map(pose_at(x=-3.0))
    assert (told.stamp_s, told.inflation) == (7.5, 1.0)
    assert np.all(np.linalg.norm(told.points - [-3.0, 0.0, 1.5], axis=1) < config.memory.local_radius_m)
    assert len(points(memory, x=-9.0)) == 0


def test_a_mirrored_view_of_an_image_is_an_image(memory):
    depth = np.zeros((48, 64))
    depth[20:28, 2:8] = 2.0
    see(memory, DepthFrame(0.0, depth[:, ::-1]))
    assert np.all(points(memory)[:, 1] < 0)


@pytest.mark.parametrize("x", [np.nan, np.inf, 1e300])
def test_a_diverged_estimate_marks_nothing_and_clears_nothing(memory, x):
    see(memory, wall_at(2.0))
    before = points(memory)
    see(memory, wall_at(2.0, 0.05), pose_at(x=x))
    assert np.array_equal(points(memory), before)
    assert len(points(memory, x=x)) == 0


def test_copies_go_on_alike_and_apart(memory):
    rng = np.random.default_rng(1)
    frames = [DepthFrame(i / 20, rng.uniform(0.2, 6.0, (48, 64))) for i in range(12)]
    for i, frame in enumerate(frames[:6]):
        see(memory, frame, pose_at(yaw=0.2 * i))
    twin, before = copy.deepcopy(memory), len(memory)
    for copied in (memory, twin):
        assert len(twin) == before
        for i, frame in enumerate(frames[6:]):
            see(copied, frame, pose_at(yaw=0.2 * i))
    assert np.array_equal(points(twin), points(memory))


class SlowMemory:
    """The same memory, a cell and a pixel at a time: what its cells are, when it saw each, and where."""

    def __init__(self, config, camera):
        self.config, self.camera, self.seen = config, camera, {}

    def observe(self, frame, pose):
        c, turn = self.config, turned_by(pose.attitude)
        eye, pixels = pose.position + turn @ [self.camera.ahead_m, 0.0, 0.0], {}
        for r, k in np.ndindex(*frame.depth.shape):
            if c.min_range_m <= frame.depth[r, k] <= c.max_range_m:
                point = eye + turn @ (self.camera.rays[r, k] * frame.depth[r, k])
                pixels.setdefault(int(cells_at(point[None], c.voxel_m)[0]), []).append(point)
        fresh = {cell: points[0] for cell, points in pixels.items() if len(points) >= c.min_pixels}
        forget = {
            cell
            for cell, (when, centre) in self.seen.items()
            if cell not in fresh
            and (when < frame.stamp_s - c.max_age_s or self.through(turn.T @ (centre - eye), frame.depth))
        }
        self.seen = {cell: one for cell, one in self.seen.items() if cell not in forget}
        for cell, point in fresh.items():
            self.seen[cell] = (frame.stamp_s, (np.floor(point / c.voxel_m) + 0.5) * c.voxel_m)
        return forget

    def through(self, centre, depth):
        c, (ahead, left, up) = self.config, centre
        if not c.min_range_m < ahead < c.max_range_m:
            return False
        k = int(np.floor((left / ahead - self.camera.column[0]) / self.camera.column[1] + 0.5))
        r = int(np.floor((up / ahead - self.camera.row[0]) / self.camera.row[1] + 0.5))
        if not (0 <= k < depth.shape[1] and 0 <= r < depth.shape[0]):
            return False
        return bool(depth[r, k] == 0.0 or depth[r, k] > ahead + c.clear_margin_m)


@pytest.mark.parametrize("seed", range(3))
def test_the_memory_equals_a_slow_one(memory, config, camera, seed):
    rng = np.random.default_rng(seed)
    slow = SlowMemory(config.memory, camera)
    for i in range(6):
        blocks = np.kron(rng.uniform(0.2, 5.5, (6, 8)), np.ones((8, 8)))
        depth = np.where(rng.random(blocks.shape) < 0.1, 0.0, blocks + rng.normal(0, 0.02, blocks.shape))
        pose = pose_at(*rng.uniform(-1, 1, 3), yaw=rng.uniform(-3, 3) * (i % 2), pitch=rng.uniform(-0.3, 0.3))
        frame = DepthFrame(4.5 * i, depth)
        assert set(see(memory, frame, pose).forget.tolist()) == slow.observe(frame, pose)
        occupied = memory.observe(frame, pose).occupied.tolist()
        memory.update(None)
        assert sorted(occupied) == sorted(slow.seen)
