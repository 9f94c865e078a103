// Plays the motion of a structure: lines as tubes, links as rods, bodies as boxes, supports as dark cubes.
"use strict";
{
  const data = JSON.parse(document.getElementById("data").textContent);
  const { lines, links, bodies, supports, frames, reference } = data;
  const element = (id) => document.getElementById(id);
  const vector = (values, point) => new THREE.Vector3().fromArray(values, 3 * point);

  // Extent of all frames, without points that are not finite.
  const box = new THREE.Box3();
  for (const { points } of [reference, ...frames]) {
    for (let point = 0; 3 * point < points.length; point++) {
      const position = vector(points, point);
      if (Number.isFinite(position.lengthSq())) box.expandByPoint(position);
    }
  }
  const center = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3()).length() || 1;

  // Without WebGL three.js throws an error, and this stays.
  element("time").textContent = "This page needs WebGL.";
  const renderer = new THREE.WebGLRenderer({ antialias: true });
  document.body.prepend(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xffffff);
  scene.add(new THREE.AmbientLight(0xffffff, 1.6));
  const camera = new THREE.PerspectiveCamera(40, 1, 0.01 * size, 100 * size);
  camera.up.set(0, 0, 1);
  // What lies in a horizontal plane is seen from above.
  const flat = box.max.z - box.min.z < 0.05 * size;
  const from = flat ? new THREE.Vector3(0.2, -0.6, 1) : new THREE.Vector3(0.6, -1, 0.5);
  camera.position.copy(center).add(from.multiplyScalar(1.2 * size));
  const lamp = new THREE.DirectionalLight(0xffffff, 2);
  scene.add(camera);
  camera.add(lamp);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.target.copy(center);
  controls.update();

  // The fixed axes, below the structure.
  const step = 10 ** Math.floor(Math.log10(size / 2));
  const cells = Math.ceil((1.5 * size) / step);
  const grid = new THREE.GridHelper(cells * step, cells, 0xbbbbbb, 0xe4e4e4);
  grid.rotateX(Math.PI / 2);
  grid.position.set(center.x, center.y, box.isEmpty() ? 0 : box.min.z - 0.02 * size);
  scene.add(grid, new THREE.AxesHelper(0.15 * size));

  // Many copies of one geometry.
  function copies(geometry, colors, count) {
    const materials = colors.map((color) => new THREE.MeshStandardMaterial({ color, roughness: 0.6 }));
    const mesh = new THREE.InstancedMesh(geometry, materials.length > 1 ? materials : materials[0], count);
    mesh.frustumCulled = false;
    scene.add(mesh);
    return mesh;
  }
  const cylinder = new THREE.CylinderGeometry(1, 1, 1, 12);
  const sphere = new THREE.SphereGeometry(1, 12, 8);
  const cube = new THREE.BoxGeometry(1, 1, 1);
  const matrix = new THREE.Matrix4();
  const upright = new THREE.Vector3(0, 1, 0);

  function between(mesh, k, from, to, radius) {
    const axis = to.clone().sub(from);
    const length = Math.max(axis.length(), 1e-9 * size);
    const turn = new THREE.Quaternion().setFromUnitVectors(upright, axis.divideScalar(length));
    const middle = from.clone().add(to).multiplyScalar(0.5);
    mesh.setMatrixAt(k, matrix.compose(middle, turn, new THREE.Vector3(radius, length, radius)));
  }

  // A structure in colours; its function shows it with other positions of its points.
  function structure(color, radius, all) {
    const segments = lines.flatMap(([first, end]) =>
      Array.from({ length: Math.max(end - first - 1, 0) }, (_, k) => [first + k, first + k + 1]));
    const round = [...new Set(segments.flat())];
    const tubes = copies(cylinder, [color], segments.length);
    const joints = copies(sphere, [color], round.length);
    const rods = copies(cylinder, [all ? 0x909090 : color], links.length);
    const boxes = copies(cube, [0xd55e00, 0xd55e00, 0xe69f00, 0xe69f00, 0xf0c070, 0xf0c070], all ? bodies.length : 0);
    const ground = copies(cube, [0x303030], all ? supports.length : 0);
    const none = new THREE.Quaternion();
    return (points, axes) => {
      const at = (point) => vector(points, point);
      segments.forEach(([from, to], k) => between(tubes, k, at(from), at(to), radius));
      round.forEach((point, k) =>
        joints.setMatrixAt(k, matrix.compose(at(point), none, new THREE.Vector3(radius, radius, radius))));
      links.forEach(([from, to], k) => between(rods, k, at(from), at(to), 0.5 * radius));
      if (all) {
        bodies.forEach((point, k) => {
          const [x, y, z] = [0, 1, 2].map((column) => vector(axes, 3 * k + column).multiplyScalar(6 * radius));
          boxes.setMatrixAt(k, matrix.makeBasis(x, y, z).setPosition(at(point)));
        });
        const edge = new THREE.Vector3(1, 1, 1).multiplyScalar(3 * radius);
        supports.forEach((point, k) => ground.setMatrixAt(k, matrix.compose(at(point), none, edge)));
      }
      for (const mesh of [tubes, joints, rods, boxes, ground]) mesh.instanceMatrix.needsUpdate = true;
    };
  }
  structure(0xc8c8c8, 0.0015 * size, false)(reference.points, reference.axes);
  const show = structure(0x0072b2, 0.006 * size, true);

  // Rows are shown at their times, those of a path that turns back one after the other.
  const ascending = frames.every(({ t }, k) => k === 0 || t > frames[k - 1].t);
  const times = frames.map(({ t }, k) => (ascending ? t : k));
  const [start, end] = [times[0], times[times.length - 1]];
  const mixed = (a, b, part) => a.map((x, k) => x + part * (b[k] - x));

  function showAt(time) {
    const next = Math.max(times.findIndex((t) => t >= time), 1);
    const [a, b] = [frames[next - 1], frames[Math.min(next, frames.length - 1)]];
    const span = times[Math.min(next, frames.length - 1)] - times[next - 1];
    const part = span > 0 ? Math.min(Math.max((time - times[next - 1]) / span, 0), 1) : 0;
    show(mixed(a.points, b.points, part), mixed(a.axes, b.axes, part));
    element("time").textContent = `${data.parameter} = ${(a.t + part * (b.t - a.t)).toPrecision(4)}`;
    element("slider").value = end > start ? (time - start) / (end - start) : 1;
  }

  // The address may end in #t=0.5, which shows that time.
  const wanted = Number.parseFloat(new URLSearchParams(window.location.hash.slice(1)).get("t"));
  let time = Number.isNaN(wanted) ? start : Math.min(Math.max(wanted, start), end);
  let playing = Number.isNaN(wanted) && end > start;
  let before = null;
  function play(on) {
    playing = on;
    element("play").textContent = on ? "Pause" : "Play";
  }
  play(playing);
  element("play").onclick = () => {
    if (!playing && time >= end) time = start;
    play(!playing);
  };
  element("slider").oninput = (event) => {
    play(false);
    time = start + event.target.valueAsNumber * (end - start);
  };

  function resize() {
    camera.aspect = window.innerWidth / window.innerHeight;
    camera.updateProjectionMatrix();
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(window.innerWidth, window.innerHeight);
  }
  window.onresize = resize;
  resize();

  // The whole run takes eight seconds.
  const speed = (end - start) / 8000;
  renderer.setAnimationLoop((now) => {
    if (playing && before !== null) {
      time += speed * (now - before);
      if (time >= end) {
        time = end;
        play(false);
      }
    }
    before = now;
    showAt(time);
    renderer.render(scene, camera);
  });
}
