// The bodies in three dimensions, by WebGL.

{
  const canvas = document.getElementById("view3d");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });

  const add = (a, b, s = 1) => a.map((c, k) => c + s * b[k]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const norm = Math.hypot(...a) || 1; return a.map((c) => c / norm); };

  /** The columns of the rotation matrix of a quaternion x, y, z, w. */
  const columns = ([x, y, z, w]) => [
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
  ];
  /** A 4 by 4 matrix by columns from three columns and an origin. */
  const placed = ([a, b, c], o) => [...a, 0, ...b, 0, ...c, 0, ...o, 1];
  const product = (a, b) => Array.from({ length: 16 }, (_, n) => {
    const [column, row] = [n >> 2, n & 3];
    let sum = 0;
    for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
    return sum;
  });

  const program = (vertex, fragment) => {
    const made = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, `precision highp float;\n${source}`);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    return made;
  };

  /** Buffers of triangles; normals are the mean of those of the triangles about a vertex. */
  const buffers = (points, triangles) => {
    const normals = new Float32Array(points.length);
    for (let t = 0; t < triangles.length; t += 3) {
      const corner = (k) => Array.from(points.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3));
      const [a, b, c] = [0, 1, 2].map(corner);
      const normal = cross(add(b, a, -1), add(c, a, -1));
      for (let k = 0; k < 3; k++) for (let i = 0; i < 3; i++) normals[3 * triangles[t + k] + i] += normal[i];
    }
    const filled = (target, data) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, data, gl.STATIC_DRAW);
      return buffer;
    };
    return {
      points: filled(gl.ARRAY_BUFFER, points),
      normals: filled(gl.ARRAY_BUFFER, normals),
      triangles: filled(gl.ELEMENT_ARRAY_BUFFER, triangles),
      count: triangles.length,
    };
  };

  /** A cylinder of unit radius from z = 0 to z = 1. */
  const tube = () => {
    const [points, triangles, sides] = [[], [], 16];
    for (let k = 0; k < sides; k++) {
      const angle = 2 * Math.PI * k / sides;
      points.push(Math.cos(angle), Math.sin(angle), 0, Math.cos(angle), Math.sin(angle), 1);
      const [a, b] = [2 * k, 2 * ((k + 1) % sides)];
      triangles.push(a, b, b + 1, a, b + 1, a + 1);
    }
    return buffers(new Float32Array(points), new Uint32Array(triangles));
  };

  const start = () => {
    gl.getExtension("OES_element_index_uint");
    const lit = program(
      `attribute vec3 point, normal; uniform mat4 model, camera; varying vec3 n;
       void main() { n = mat3(model) * normal; gl_Position = camera * model * vec4(point, 1.0); }`,
      `uniform vec3 colour, light; varying vec3 n;
       void main() { float d = 0.5 + 0.5 * dot(normalize(n), light);
         gl_FragColor = vec4(colour * (0.3 + 0.7 * d * d) + 0.12 * pow(d, 24.0), 1.0); }`);
    const flat = program(
      `attribute vec3 point; uniform mat4 camera; void main() { gl_Position = camera * vec4(point, 1.0); }`,
      `uniform vec4 colour; void main() { gl_FragColor = colour; }`);
    const textured = program(
      `attribute vec3 point; attribute vec2 place; uniform mat4 camera; varying vec2 p;
       void main() { p = place; gl_Position = camera * vec4(point, 1.0); }`,
      `uniform sampler2D image; varying vec2 p;
       void main() { vec4 c = texture2D(image, p); gl_FragColor = c * 0.92; }`);

    const meshes = run.meshes.map((mesh) =>
      buffers(unpacked(mesh.points, Float32Array), unpacked(mesh.triangles, Uint32Array)));
    const link = tube();
    const view = run.view;
    const aspect = canvas.clientWidth / canvas.clientHeight;
    const back = unit(cross(view.right, view.up));
    const size = Math.max(view.width, 1.15 * view.height * aspect);
    let smallest = Infinity;
    run.meshes.forEach((mesh) => {
      let radius = 0;
      const points = unpacked(mesh.points, Float32Array);
      for (let k = 0; k < points.length; k += 3) radius = Math.max(radius, Math.hypot(points[k], points[k + 1], points[k + 2]));
      smallest = Math.min(smallest, radius);
    });
    if (!Number.isFinite(smallest)) smallest = 0.05 * size;
    const first = { yaw: 0.45, pitch: 0.35, zoom: 1 };
    const camera = { ...first };
    const dynamic = gl.createBuffer();
    const texture = gl.createTexture();
    const picture = document.createElement("canvas");
    let pictured = null;

    const middle = (time) => {
      const sum = run.bodies.reduce((s, _, body) => add(s, poseAt(body, time).x), [0, 0, 0]);
      return sum.map((c) => c / run.bodies.length);
    };

    /** The camera matrix, and the direction to the light. */
    const look = (time) => {
      const follow = document.getElementById("follow").checked;
      const target = follow ? middle(time) : view.centre;
      const [cy, sy, cp, sp] = [Math.cos(camera.yaw), Math.sin(camera.yaw), Math.cos(camera.pitch), Math.sin(camera.pitch)];
      const at = (r, u, b) => add(add(view.right.map((c) => c * r), view.up, u), back, b);
      const towards = at(-sy * cp, sp, cy * cp);
      const right = at(cy, 0, sy);
      const up = cross(towards, right);
      const distance = 1.3 * size / camera.zoom;
      const eye = add(target, towards, distance);
      const axes = [right, up, towards];
      const world = [0, 1, 2].map((k) => axes.map((axis) => axis[k]));
      const viewing = placed(world, axes.map((axis) => -dot(axis, eye)));
      const focal = 2.6, shape = canvas.width / canvas.height;
      const [near, far] = [0.02 * distance, distance + 40 * size];
      const perspective = [focal / shape, 0, 0, 0, 0, focal, 0, 0,
        0, 0, -(far + near) / (far - near), -1, 0, 0, -2 * far * near / (far - near), 0];
      const light = unit(add(add(towards, up, 0.7), right, -0.5));
      return { matrix: product(perspective, viewing), light };
    };

    const solid = (mesh, model, colour, { matrix, light }) => {
      gl.useProgram(lit);
      const uniform = (name) => gl.getUniformLocation(lit, name);
      gl.uniformMatrix4fv(uniform("model"), false, model);
      gl.uniformMatrix4fv(uniform("camera"), false, matrix);
      gl.uniform3fv(uniform("colour"), colour);
      gl.uniform3fv(uniform("light"), light);
      for (const [name, buffer] of [["point", mesh.points], ["normal", mesh.normals]]) {
        attribute(lit, name, buffer, 3, 0, 0);
      }
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.triangles);
      gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
    };

    const attribute = (made, name, buffer, count, stride, offset) => {
      const place = gl.getAttribLocation(made, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, gl.FLOAT, false, stride, offset);
    };

    const lines = (points, colour, { matrix }) => {
      gl.useProgram(flat);
      gl.bindBuffer(gl.ARRAY_BUFFER, dynamic);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.DYNAMIC_DRAW);
      attribute(flat, "point", dynamic, 3, 0, 0);
      gl.uniformMatrix4fv(gl.getUniformLocation(flat, "camera"), false, matrix);
      gl.uniform4fv(gl.getUniformLocation(flat, "colour"), [...colour, 1]);
      gl.drawArrays(gl.LINE_STRIP, 0, points.length / 3);
    };

    /** The picture of the slice as a rectangle in space, drawn again when it changes. */
    const slicePlane = (slice, { matrix }) => {
      const name = document.getElementById("quantity").value;
      const { plane } = slice;
      gl.bindTexture(gl.TEXTURE_2D, texture);
      if (pictured !== `${slice.time} ${name}`) {
        pictured = `${slice.time} ${name}`;
        [picture.width, picture.height] = [1024, Math.round(1024 * plane.height / plane.width)];
        drawSlice(picture.getContext("2d"), slice, name, 0, 0, picture.width, picture.height, 1.6);
        gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
        gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
      }
      const data = [[0, 0], [1, 0], [0, 1], [1, 1]].flatMap(([a, b]) =>
        [...add(add(plane.centre, plane.right, (a - 0.5) * plane.width), plane.up, (b - 0.5) * plane.height), a, b]);
      gl.useProgram(textured);
      gl.bindBuffer(gl.ARRAY_BUFFER, dynamic);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.DYNAMIC_DRAW);
      attribute(textured, "point", dynamic, 3, 20, 0);
      attribute(textured, "place", dynamic, 2, 20, 12);
      gl.uniformMatrix4fv(gl.getUniformLocation(textured, "camera"), false, matrix);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    };

    const draw = () => {
      const pixel = window.devicePixelRatio || 1;
      const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((n) => Math.max(1, Math.round(n * pixel)));
      if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
      gl.viewport(0, 0, width, height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      const time = player.time;
      const seen = look(time);
      const grey = unitColour(styleColour("--soft"));
      const poses = run.bodies.map((_, body) => poseAt(body, time));
      run.bodies.forEach(({ mesh, colour }, body) => {
        const { x, q } = poses[body];
        if (mesh !== null) solid(meshes[mesh], placed(columns(q), x), unitColour(colour), seen);
      });
      for (const [from, to] of run.links) {
        const arm = add(poses[to].x, poses[from].x, -1);
        const length = Math.hypot(...arm);
        if (length < 1e-9 * size) continue;
        const along = unit(arm);
        const aside = unit(cross(along, Math.abs(along[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
        const radius = 0.08 * smallest;
        const axes = [aside.map((c) => c * radius), cross(along, aside).map((c) => c * radius), arm];
        solid(link, placed(axes, poses[from].x), grey, seen);
      }
      const { low } = stepAt(time);
      run.bodies.forEach(({ colour }, body) => {
        const path = [];
        const from = Math.max(0, low - 1500);
        for (let step = from; step <= low; step++) {
          const at = 7 * (step * run.bodies.length + body);
          path.push(track.poses[at], track.poses[at + 1], track.poses[at + 2]);
        }
        lines([...path, ...poses[body].x], unitColour(colour), seen);
      });
      const slice = document.getElementById("show-flow").checked && nearestSlice(time);
      if (slice) slicePlane(slice, seen);
    };

    const turn = (yaw, pitch) => {
      camera.yaw += yaw;
      camera.pitch = Math.min(1.5, Math.max(-1.5, camera.pitch + pitch));
      draw();
    };
    const zoom = (factor) => {
      camera.zoom = Math.min(20, Math.max(0.1, camera.zoom * factor));
      draw();
    };
    const keys = {
      ArrowLeft: () => turn(-0.12, 0), ArrowRight: () => turn(0.12, 0),
      ArrowUp: () => turn(0, 0.12), ArrowDown: () => turn(0, -0.12),
      "+": () => zoom(1.2), "=": () => zoom(1.2), "-": () => zoom(1 / 1.2),
      0: () => { Object.assign(camera, first); draw(); },
    };
    canvas.addEventListener("keydown", (event) => {
      if (!keys[event.key] || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      keys[event.key]();
    });
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) turn(-0.008 * event.movementX, 0.008 * event.movementY);
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(Math.exp(-0.0015 * event.deltaY));
    }, { passive: false });
    for (const id of ["show-flow", "follow"]) document.getElementById(id).addEventListener("change", draw);
    player.onChange(draw);
    new ResizeObserver(draw).observe(canvas);
    onThemeChange(draw);
  };

  if (gl) start();
  else document.getElementById("view3d-note").textContent = "This browser has no WebGL, which the view needs.";
}
