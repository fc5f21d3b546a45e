"""An example of every built-in node type and skill: for the tree reference, and for `humanoid-bt nodes`."""

from __future__ import annotations

EXAMPLES = {
    "sequence": """\
sequence:
  - approach: {target: target}
  - reach: {target: target}
  - retract: {hand: both}
""",
    "selector": """\
selector:
  name: get near
  children:
    - within: {percept: target, distance: 0.5 m}
    - approach: {target: target, distance: 0.4 m}
""",
    "reactive_sequence": """\
reactive_sequence:
  - confident: {percept: target, above: 0.6}
  - approach: {target: target}
""",
    "reactive_selector": """\
reactive_selector:
  - guard:
      condition: distance(target) < 0.7 m hysteresis 0.1 m
      reach: {target: target}
  - idle
""",
    "parallel": """\
parallel:
  success: one               # ends as soon as the hand is there
  children:
    - reach: {target: target, hand: left}
    - timeout: {duration: 5 s, wait_until: distance(target) < 0.6 m}
""",
    "if": """\
if:
  condition: distance(target) < 0.5 m
  then: {reach: {target: target}}
  else: {approach: {target: target}}
""",
    "switch": """\
switch:
  value: bearing(target) > 0 deg
  cases:
    true: {reach: {target: target, hand: left}}
    false: {reach: {target: target, hand: right}}
""",
    "reactive_if": """\
reactive_if:
  condition: distance(target) < 0.5 m hysteresis 5 cm
  then: {reach: {target: target}}
  else: {approach: {target: target}}
""",
    "reactive_switch": """\
reactive_switch:
  value: state.gait
  cases:
    stand: {reach: {target: target}}
    step: {timeout: {duration: 3 s, wait_until: state.standing}}
  default: {log: the robot settles}
""",
    "for_each": """\
for_each:
  item: side
  items: [left, right]
  reach: {target: target, hand: $side}
""",
    "while": """\
while:
  condition: distance(target) > 0.6 m
  approach: {target: target, distance: 0.5 m}
""",
    "keep_running_until_failure": """\
keep_running_until_failure:
  sequence:
    - wait: 1 s
    - condition: target.confidence > 0.3 hysteresis 0.1
""",
    "delay": """\
delay:
  duration: 500 ms
  reach: {target: target}
""",
    "cooldown": """\
reactive_selector:
  - cooldown:
      duration: 10 s
      timeout: {duration: 3 s, reach: {target: target}}
  - idle
""",
    "min_duration": """\
min_duration:
  duration: 2 s
  approach: {target: target}
""",
    "precondition": """\
precondition:
  condition: state.standing
  reach: {target: target}
""",
    "guard": """\
guard:
  condition: distance(target) < 0.7 m hysteresis 0.1 m
  reach: {target: target}
""",
    "once": """\
retry:
  attempts: 3
  sequence:
    - once: {log: "the target is {distance(target)} away"}
    - reach: {target: target}
""",
    "on_error": """\
selector:
  - on_error:
      reach: {target: target}
  - idle
""",
    "status_to_blackboard": """\
parallel:
  - status_to_blackboard:
      key: reaching
      reach: {target: target}
  - wait_until: reaching == 'success'
""",
    "force_success": """\
sequence:
  - force_success:
      timeout: {duration: 5 s, approach: {target: target}}
  - reach: {target: target}
""",
    "force_failure": """\
selector:
  - force_failure: {log: trying to reach}
  - reach: {target: target}
""",
    "running_is_failure": """\
selector:
  - running_is_failure:
      wait_until: state.standing
  - idle
""",
    "running_is_success": """\
running_is_success:
  approach: {target: target}
""",
    "failure_is_running": """\
failure_is_running:
  within: {percept: target, distance: 0.5 m}
""",
    "success_is_running": """\
success_is_running:
  confident: {percept: target, above: 0.6}
""",
    "subtree": """\
subtree: stand
""",
    "condition": """\
condition: target.confidence > 0.6 hysteresis 0.1 and abs(bearing(target)) < 30 deg
""",
    "success": """\
selector:
  - reach: {target: target}
  - success
""",
    "failure": """\
sequence:
  - log: giving up
  - failure
""",
    "running": """\
sequence:
  - timeout: {duration: 5 s, reach: {target: target}}
  - running
""",
    "log": """\
log: {text: "{distance(target)} away, seen {age(target)} ago", level: warning}
""",
    "wait": """\
wait: 2 s
""",
    "wait_until": """\
wait_until: state.standing
""",
    "set_blackboard": """\
sequence:
  - set_blackboard: {key: tries, value: 0}
  - set_blackboard: {key: tries, expression: tries + 1}
""",
    "clear_blackboard": """\
sequence:
  - set_blackboard: {key: place, value: kitchen}
  - clear_blackboard: place
""",
    "inverter": """\
inverter:
  within: {percept: target, distance: 30 cm}
""",
    "retry": """\
retry:
  attempts: 3
  reach: {target: target}
""",
    "repeat": """\
repeat:
  times: 2
  reach: {target: target}
""",
    "timeout": """\
timeout:
  duration: 20 s
  approach: {target: target}
""",
    "emergency_stop": """\
emergency_stop: idle
""",
    "watchdog": """\
watchdog:
  percept: target
  max_age: 500 ms
  on_stale: idle
  reach: {target: target}
""",
    "confident": """\
confident: {percept: target, above: 0.6, hysteresis: 0.1}
""",
    "within": """\
within: {percept: target, distance: 0.5 m, bearing: 25 deg}
""",
    "raise_emergency_stop": """\
raise_emergency_stop: {reason: the target is gone}
""",
    "ros_service": """\
sequence:
  - ros_service: {service: /lamp, type: std_srvs/SetBool, request: {data: true}, response: {message: answer}}
  - log: "the lamp says {answer}"
""",
    "ros_action": """\
ros_action:
  action: /lift
  type: my_interfaces/action/Lift
  goal: {floor: 2, speed: "{0.5 m/s}"}
  feedback: height
  timeout: 60 s
""",
    "approach": """\
approach: {target: target, distance: 0.4 m}
""",
    "idle": """\
idle: {look_around: false}
""",
    "reach": """\
reach: {target: target, hand: left, hold: 1 s}
""",
    "look_at": """\
look_at: {target: target, hold: 1 s}
""",
    "point_at": """\
point_at: {target: target, hold: 2 s}
""",
    "touch_with_both": """\
touch_with_both: {target: target, width: 20 cm}
""",
    "offer": """\
offer: {target: target, height: 90 cm, hold: 5 s}
""",
    "retract": """\
retract: {hand: both}
""",
    "step_back": """\
step_back: {distance: 30 cm}
""",
    "touch": """\
touch: {hand: left, direction: down, force: 10 N}
""",
    "turn": """\
turn: {angle: -90 deg}
""",
    "walk_to": """\
walk_to: {x: 1 m, y: -0.5 m, heading: 90 deg}
""",
    "wave": """\
wave: {target: target, times: 2}
""",
}
"""Node type -> a short example, each loaded by a test."""
