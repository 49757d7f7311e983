"""The live page over a slide of the virtual rig and its twin, without ROS.

`python serve_slide.py SPEED [SECONDS_BEFORE]`

Prints its address, then follows orders on stdin: `requests` prints what was asked for on the page, `rss` the process's
kB and CPU seconds, `die` ends rig and controller but not the page.
"""

import json
import math
import resource
import sys
import threading
import time

from slider_drilling.api.rigs import load_rig
from slider_drilling.control import SlideController
from slider_drilling.control.interface import Level, Status
from slider_drilling.drillstring import VirtualRig
from slider_drilling.live.page_requests import RequestQueue, SetParameter, SetTarget
from slider_drilling.live.server import Address, PageServer
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.twin import Twin, TwinReport, TwinSettings
from slider_drilling.twin.gap_diagnosis import gap_diagnosis


class Slide:
    """Steps controller and rig and tells the page what nodes would."""

    def __init__(self, state: LiveState) -> None:
        self.state = state
        rig = load_rig()
        self.rig, self.controller = VirtualRig(rig, elements=40), SlideController(rig)
        self.twin = Twin(rig, TwinSettings(learning=60.0))
        self.controller.tool_face_target = state.target = math.radians(45.0)
        state.set_rig(rig)
        state.recording = True
        state.update_parameters(
            [LiveParameter("rocking_controller", "gain", 2.0, "-", 0.0, 8.0, "centre shift per error"),
             LiveParameter("rocking_controller", "friction_factor", 0.235, "-", 0.02, 1.0, "assumed until measured"),
             LiveParameter("rocking_controller", "amplitude", 0.0, "rad", 0.0, 200.0, "of rocking; 0: automatic"),
             LiveParameter("rocking_controller", "make_up_torque_limit", 25000.0, "N m", 0.0, 1e5, "to the right"),
             # Such names are run as a script where they reach the text of NiceGUI's props.
             LiveParameter("rocking_controller", "a :hint=window.hacked=1 onclick='window.hacked=1'", 1.0, "-", 0.0,
                           1.0, "<img src=x onerror=window.hacked=1>; 0: <script>window.hacked=1</script>")]
        )

    def step(self) -> None:
        state, m = self.state, self.rig.step(self.controller.step(self.rig.measurements))
        state.set_pressure(m.time, m.standpipe_pressure)
        state.set_pump_speed(m.time, m.pump_speed)
        for sample in m.mwd:
            state.add_tool_face(sample.measured_at, sample.tool_face)
        state.truth = self.rig.truth.tool_face
        state.set_block(m.time, m.block_position, m.hook_load)
        state.add_sample(m.time, m.top_drive_angle, m.surface_torque)
        self.twin.add_measurements(m)
        for report in self.twin.advance():
            self.tell(report)
        if round(m.time * 10) % 10 == 0:
            state.update_statuses(
                Status(one.level, f"rocking_controller: {one.name}", one.message, one.values)
                for one in self.controller.status()
            )
            state.update_statuses([Status(Level.OK, "someone: log", 2000 * "x")])  # one word must not widen the page

    def tell(self, report: TwinReport) -> None:
        """What the twin's topics would bring to the page."""
        twin = self.state.twin
        for k, at in enumerate(report.samples.tolist()):
            for channel, values in report.expected.items():
                twin.set_expected(channel, at, float(values[k]))
            twin.finish_expected(at, self.state.circulation_at(at))
        for seconds in (10, 60, 300):
            twin.set_gaps(seconds, {name: getattr(one, f"gap_{seconds}") for name, one in report.channels.items()})
        twin.set_thresholds({name: one.threshold for name, one in report.channels.items()})
        for bound, end in (("value", "value"), ("lower", "low"), ("upper", "high")):
            numbers = {name: getattr(trend, end) for name, trend in report.trends.items()}
            twin.set_trends(bound, report.time, numbers)
        twin.set_diagnosis(json.dumps(gap_diagnosis(report, 0.0, self.twin.answer, self.twin.answered)))


def main(speed: float, before: float) -> None:
    state, requests, received = LiveState(), RequestQueue(), []
    slide = Slide(state)
    while slide.rig.measurements.time < before:
        slide.step()
    server = PageServer(state, requests, Address(port=0))
    print(server.url, flush=True)

    def run() -> None:
        due = time.monotonic()
        while running.is_set():
            slide.step()
            for request in requests.take():
                received.append(request)
                if isinstance(request, SetTarget):
                    slide.controller.tool_face_target = state.target = request.target
                    state.add_notice(f"target {math.degrees(request.target):.1f} deg", success=True)
                elif isinstance(request, SetParameter):
                    state.add_notice(f"{request.name} = {request.value:g}: refused: out of range", success=False)
            due += 0.1 / speed
            time.sleep(max(due - time.monotonic(), 0.0))

    running = threading.Event()
    running.set()
    threading.Thread(target=run, daemon=True).start()
    for line in sys.stdin:
        if line.strip() == "requests":
            print(received, flush=True)
        elif line.strip() == "die":
            running.clear()
            print("dead", flush=True)
        elif line.strip() == "rss":
            with open("/proc/self/status") as file:
                (kilobytes,) = [row.split()[1] for row in file if row.startswith("VmRSS")]
            used = resource.getrusage(resource.RUSAGE_SELF)
            print(kilobytes, used.ru_utime + used.ru_stime, flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 0.0)
