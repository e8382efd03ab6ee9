"""Task files for tests: a plain one to change, and one that uses every feature of the format."""

PLAIN = """\
task: plain
summary: Two arms and a cube.
instructions: ["take the {cube.color} cube"]
timing: {control_hz: 10, physics_hz: 120}
scene:
  robots:
    left: {model: ur5e, base: {position: [-0.8, 0, 0.4]}}
    right: {model: ur5e, base: {position: [0.8, 0, 0.4], rpy_deg: [0, 0, 180]}}
  objects:
    table: {shape: {box: [2, 1, 0.04]}, fixed: true, position: [0, 0, 0.38]}
    cube:
      shape: {box: [0.05, 0.05, 0.05]}
      mass: 0.1
      color: red
      grasps: {middle: {}}
      place: {surface: table, center: [-0.3, 0], size: [0.1, 0.2]}
  sites:
    goal: {marker: {sphere: 0.03}, position: [0.3, 0, 0.6]}
    meeting: {position: [0, 0, 0.6]}
  cameras:
    front: {position: [0, -1.4, 1.3], look_at: [0, 0, 0.5]}
observe:
  left: [self.tcp, cube.pose]
  right: [self.tcp]
expert:
  - left: {grasp: cube.middle}
  - left: {bring: cube, to: goal}
"""

CABINET = """\
<robot name="cabinet">
  <link name="base"/>
  <link name="drawer">
    <inertial>
      <mass value="0.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="door">
    <inertial>
      <mass value="0.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="drawer"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.3" effort="10" velocity="1"/>
  </joint>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="door"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1.6" effort="10" velocity="1"/>
  </joint>
</robot>
"""

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

ONE_OF_EVERYTHING = """\
task: everything
version: 2
summary: Every feature of the format, once.
instructions:
  - put the {pebble.color} pebble of {pebble.mass} kg into {tray.color}
  - "no fields, but {{braces}}"
cooperation: optional
timing: {control_hz: 20, physics_hz: 240, episode_steps: 80, ends_on: [success, failure]}

scene:
  floor: false
  robots:
    left:
      model: ur5e
      base: {position: [-0.8, 0, 0.4]}
      home: {tcp: {position: [-0.35, 0, 0.6], rpy_deg: [180, 0, 90]}}
      action:
        {arm: tcp_delta, frame: base, max_step: 0.04, turn: full, max_turn_deg: 10, gripper: binary}
    right:
      model: panda
      base: {position: [0.8, 0, 0.4], rpy_deg: [0, 0, 180]}
      home: {joints_deg: [0, -45, 0, -135, 0, 90, 45]}
      postures: {tucked: {joints_deg: [0, -60, 0, -150, 0, 90, 45]}}
      action: {arm: joint_position, gripper: continuous}
    third:
      model: xarm6
      base: {position: [0, 0.8, 0.4]}
      grasp: {rule: attach, distance: 0.03, force: 30}
  objects:
    table: {shape: {box: [1.8, 1.2, 0.04]}, fixed: true, position: [0, 0, 0.38], color: wood}
    mug: {object: mug, position: [-0.5, -0.4, 0.4]}
    ball:
      shape: {sphere: 0.03}
      mass: 0.05
      friction: 0.9
      rolling_friction: 0.001
      restitution: 0.3
      color: "#ff8800"
      place: {in: left.base, center: [0.3, 0, 0.5], size: [0.1, 0.1, 0.2], rpy_deg: [0, 90, 0]}
    rod:
      shape: {cylinder: {radius: 0.01, length: 0.2}}
      mass: 0.05
      color: [0.2, 0.4, 0.6]
      position: [0, 0.2, 0.05]
      rpy_deg: [0, 90, 0]
      in: table
    pill: {shape: {capsule: {radius: 0.01, length: 0.02}}, mass: 0.01, position: [0.5, 0.3, 0.5]}
    pebble:
      shape: {mesh: assets/pebble.obj, collision: assets/pebble.obj, collide: hull, scale: 0.05}
      mass: 0.2
      color: teal
      grasps:
        top: {at: [0, 0, 0.01], approach: down, across: x}
        side: {approach: -x, across: z}
      place: {surface: tray.floor, in: tray, center: [0, 0], size: [0.05, 0.05], yaw_deg: [-15, 15]}
    tray:
      parts:
        floor: {box: [0.2, 0.2, 0.01], at: [0, 0, 0.005]}
        pin: {cylinder: {radius: 0.01, length: 0.05}, at: [0.09, 0, 0.03], rpy_deg: [0, 5, 0]}
        knob: {sphere: 0.02, at: [-0.09, 0, 0.03], color: red}
        post: {capsule: {radius: 0.01, length: 0.03}, at: [0, 0.09, 0.03]}
      mass: 0.3
      grasps: {rim: {at: [-0.1, 0, 0.02], across: y, inside: true}}
      place: {surface: table, center: [0.2, 0], size: [0.06, 0.1]}
    pins: {shape: {sphere: 0.01}, fixed: true, count: 2, arrange: {line: 0.1}, position: [0, 0, 2]}
    tiles:
      shape: {box: [0.02, 0.02, 0.01]}
      mass: 0.01
      count: 3
      arrange: {grid: {columns: 2, spacing: [0.03, 0.04]}}
      place:
        {surface: table, center: [-0.5, 0.3], size: [0.02, 0.02], yaw_deg: [0, 90], clearance: 0.01}
    posts:
      shape: {cylinder: {radius: 0.01, length: 0.05}}
      mass: 0.02
      count: 4
      arrange: {ring: 0.05}
      position: [-0.5, -0.3, 0.425]
    beads:
      shape: {sphere: 0.005}
      mass: 0.002
      rolling_friction: 0.001
      count: 5
      arrange: {pile: [0.03, 0.03, 0.05]}
      position: [0.5, -0.3, 0.4]
    cabinet:
      shape: {urdf: assets/cabinet.urdf, scale: 0.5}
      fixed: true
      density: 500
      inertia: shape
      grasps: {handle: {at: [0.05, 0, 0], link: drawer}}
      joints:
        slide:
          start: 0.05
          limits: [0, 0.1]
          spring: {stiffness: 40, rest: 0.02}
          damping: 2
          friction: 1
          lock: {unless: tray at goal}
        hinge: {start_deg: 30, limits_deg: [0, 60], spring: {stiffness: 0.5, rest_deg: -10}}
      position: [0, 0.5, 0.5]
    locker:
      shape: {urdf: assets/cabinet.urdf}
      fixed: true
      joints: {sl*: {start_range: [0, 0.1]}, hinge: {start_range_deg: [10, 60]}}
      position: [0, 1.5, 0.5]
  sites:
    goal:
      marker: {box: [0.1, 0.1, 0.1]}
      opacity: 0.5
      color: green
      place: {center: [0, 0, 1], size: [0, 0, 0]}
    slot:
      marker: {cylinder: {radius: 0.02, length: 0.1}}
      in: cabinet.drawer
      position: [0, 0, 0.1]
    tip: {marker: {sphere: 0.01}, in: left.tcp, position: [0, 0, 0.02], rpy_deg: [0, 0, 45]}
  cameras:
    front: {position: [0, -1.4, 1.3], look_at: [0, 0, 0.5], fov_deg: 50, size: [320, 240]}
    wrist: {mount: left.tcp, fov_deg: 75}
    lid: {mount: cabinet.door, position: [0, 0, 0.2], look_at: [0, 0, 0], near: 0.1, far: 4}

observe:
  left:
    - self.joints
    - self.joint_velocities
    - self.tcp
    - self.tcp_velocity
    - self.gripper
    - self.holding
    - self.force
    - self.previous_action
    - pebble.pose in self.tcp
    - tray.knob.position
    - cabinet.slide
    - front.rgb
    - time_left
  right: [self.tcp, left.gripper, tray.velocity, pebble.top.position, goal.position, wrist.depth]
  third: []
observation_noise:
  left: {pebble.pose in self.tcp: {position_std: 0.002, angle_std_deg: 1}, self.joints: {std: 0.01}}
state: [left.tcp, pebble.pose, cabinet.hinge]

expert:
  - left: {grasp: pebble.top, approach: 0.1, speed: 0.5}
    right: {reach: tray.rim, above: 0.1, offset: [0, 0.02, 0], rpy_deg: [180, 0, 90]}
  - left: {bring: pebble, to: goal, above: 0.05, align: true, straight: true, tolerance: 0.005}
  - left: release
    right: {grasp: tray.rim}
  - {left: {retreat: 0.1, touching: [rod]}, right: {release: true}, third: {reach: tip}}
  - together: [left, right]
    bring: tray
    to: goal
    above: 0.02
    offset: [0, 0, 0.01]
    straight: true
    touching: [ball, pill]
    speed: 0.4
    tolerance: 0.03
  - {until: tray at goal, within: 1.5}
  - left: {slide: cabinet.slide, to: 0.08, until: failure}
    right: [{turn: cabinet.hinge, to_deg: 40, turn_tool: false, tolerance_deg: 3}, release]
    third: [{push: ball, to: [0, 0.1, 0]}, {press: cabinet.drawer, to: 0.02}]
  - {third: {press: rod, depth: 0.01}, left: home, right: {posture: tucked, speed: 0.5}}
  - repeat: 3
    unless: success
    stages:
      - {left: {close: nothing}, right: {close: tray}}
      - {repeat: 2, stages: [{left: {retreat: 0.02}}, {until: success}]}

variations:
  - {pebble.color: green, tray.mass: 0.4}
  - {pebble.place.center: [0.01, 0], goal.place: {center: [0, 0, 0.9], size: [0.1, 0.1, 0.1]}}
  - {left.home: {joints_deg: [0, -90, 90, -90, -90, 0]}, cabinet.joints: {slide: 0.1}}
randomize:
  pebble.mass: {uniform: [0.05, 0.2]}
  pebble.friction: {uniform: [0.7, 1.2]}
  ball.color: {choice: [red, "#00ff00", [0, 0, 1]]}
  goal.color: {choice: [red, blue]}
looks: [light, background, furniture, textures, distractors, cameras]
"""
