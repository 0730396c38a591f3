"""Threads and Ctrl-C: the interpreter's lock is free while bodies step, and no body is used twice at once."""

import os
import signal
import threading
import time
import unittest

import numpy as np

import support
import tremolo


class Threads(unittest.TestCase):
    def test_run_while_a_body_steps(self):
        b = support.clamped_bar().body()
        b.q[0] = 0.05
        done = threading.Event()
        worker = threading.Thread(target=lambda: (b.step(5000), done.set()))
        worker.start()
        turns = 0
        while not done.is_set() and turns < 100:
            time.sleep(0.0005)
            turns += 1
        worker.join()
        # With the lock held this thread would get no turn at all.
        self.assertGreater(turns, 3)

    def test_with_a_body_each_get_the_results_of_one(self):
        m = support.clamped_bar()
        bodies = [m.body() for _ in range(4)]
        for i, b in enumerate(bodies):
            b.q[i] = 0.03
        alone = m.body()
        alone.q[2] = 0.03
        workers = [threading.Thread(target=b.step, args=(500,)) for b in bodies]
        for worker in workers:
            worker.start()
        alone.step(500)
        for worker in workers:
            worker.join()
        np.testing.assert_array_equal(alone.q, bodies[2].q)

    def test_are_refused_a_body_that_another_steps(self):
        b = support.clamped_bar().body()
        b.q[0] = 0.05
        worker = threading.Thread(target=b.step, args=(5000,))
        refused = 0
        worker.start()
        while worker.is_alive():
            for call in (b.step, b.positions, b.save, lambda: b.energy, lambda: b.set_damping(1.0, 0.0)):
                try:
                    call()
                except tremolo.UsageError as error:
                    self.assertIn("used by another call", str(error))
                    refused += 1
        worker.join()
        self.assertGreater(refused, 0)
        b.step()

    def test_are_refused_a_world_that_another_steps(self):
        w = tremolo.world({"step": 0.003, "bodies": [
            {"name": "bar", "model": support.file_of(support.free_bar(), "free.tremolo"), "kind": "free"}]})
        b = w["bar"]
        worker = threading.Thread(target=w.step, args=(20000,))
        refused = 0
        worker.start()
        while worker.is_alive():
            for call in (w.step, w.save, b.positions, lambda: w.account("bar"), lambda: w.time):
                try:
                    call()
                except tremolo.UsageError as error:
                    self.assertIn("used by another call", str(error))
                    refused += 1
        worker.join()
        self.assertGreater(refused, 0)
        w.step()

    def test_evaluate_one_model_at_the_same_time(self):
        m = support.clamped_bar()
        q = support.some_states(m, 500)
        expected = m.force(q), m.tangent(q[:50])
        results = [None] * 6

        def work(i):
            results[i] = m.force(q) if i % 2 == 0 else m.tangent(q[:50])

        workers = [threading.Thread(target=work, args=(i,)) for i in range(6)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        for i, result in enumerate(results):
            np.testing.assert_array_equal(result, expected[i % 2])


class ControlC(unittest.TestCase):
    def interrupt(self, call):
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        timer.join()

    def test_ends_long_steps_between_two(self):
        m = support.clamped_bar()
        b, same = m.body(), m.body()
        b.q[0] = same.q[0] = 0.05
        self.interrupt(lambda: b.step(10**9))
        self.assertGreater(b.steps, 0)
        same.step(b.steps)
        np.testing.assert_array_equal(b.q, same.q)
        b.step()

    def test_ends_long_steps_of_worlds_scenes_and_own_potentials(self):
        bar = {"name": "bar", "model": support.file_of(support.free_bar(), "free.tremolo"), "kind": "free"}
        cloth = {"name": "sheet", "columns": 4, "rows": 4, "pins": ["corners"]}
        for moving in (tremolo.world({"step": 0.003, "bodies": [bar]}),
                       tremolo.load_scene({"step": 0.01, "cloths": [cloth]}),
                       tremolo.own_body(lambda q: 0.5 * q @ q, lambda q: q, lambda q: np.eye(1), q=[1.0])):
            self.interrupt(lambda moving=moving: moving.step(10**9))
            steps = moving.steps
            self.assertGreater(steps, 0)
            moving.step()
            self.assertEqual(moving.steps, steps + 1)

    def test_ends_a_response_curve(self):
        m = support.clamped_bar()
        self.interrupt(lambda: [m.response((1.0, 200.0), load=np.ones(m.modes), damping_ratio="0.1%")
                                for _ in range(10**6)])

    def test_ends_a_long_evaluation(self):
        m = support.clamped_bar()
        q = np.broadcast_to(support.some_states(m, 1), (3 * 10**6, m.modes))
        self.interrupt(lambda: [m.tangent(q[:20000]) for _ in range(10**6)])


if __name__ == "__main__":
    unittest.main()
