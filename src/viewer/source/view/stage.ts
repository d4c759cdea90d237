// The 3D view's renderer, camera and orbit. Draws only when something changed. Axes: x east, y
// north, z up, metres from the scene's origin.

import { Box3, Color, Frustum, Matrix4, MOUSE, PerspectiveCamera, Scene, Sphere, Spherical, TOUCH, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const UP = new Vector3(0, 0, 1);

/** View of the camera, m from the origin of the page. */
export interface View {
  target: [number, number, number];
  /** Returns true if a part of a sphere is in the window, even behind other objects. */
  isSeen(middle: readonly [number, number, number], radius: number): boolean;
}

function isSoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  const names = probe?.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = probe && names ? probe.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(String(name));
}

/** Returns the corners of a box: x, y, z one after the other. */
export function corners(box: Box3): number[] {
  const ends = [box.min, box.max];
  return ends.flatMap((a) => ends.flatMap((b) => ends.flatMap((c) => [a.x, b.y, c.z])));
}

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(40, 1, 0.1, 1e5);
  readonly controls: OrbitControls;
  readonly renderer: WebGLRenderer;
  /** Radius of the visible objects, m. It bounds the distance of the camera. */
  private radius = 100;
  private home: { position: Vector3; target: Vector3 } | null = null;
  /** Unit vector from the target to the side from which boxes are looked at. */
  private back: Vector3;
  private asked = false;
  /** True without a graphics card. Then smooth edges cost more than they are worth. */
  readonly software: boolean;
  private readonly afterDrawing = new Set<() => void>();
  private readonly afterMoving: (() => void)[] = [];

  constructor(readonly canvas: HTMLCanvasElement) {
    // From the south-south-east, half from above; three's sphere has y up, ours z.
    const towards = new Vector3().setFromSphericalCoords(1, 0.95, 0.45);
    this.back = new Vector3(towards.x, -towards.z, towards.y);
    this.software = isSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, powerPreference: "high-performance" });
    this.renderer.setClearColor(new Color("#d9e3ec"));
    this.camera.up.copy(UP);
    this.camera.position.set(0, -100, 60);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.screenSpacePanning = false;
    this.controls.maxPolarAngle = Math.PI * 0.55;
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    this.controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    this.controls.addEventListener("change", () => this.moved());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement ?? canvas);
    canvas.addEventListener("webglcontextrestored", () => this.draw());
    this.resize();
  }

  /** Adds a listener. Returns a function that removes it. */
  onDraw(listener: () => void): () => void {
    this.afterDrawing.add(listener);
    return () => this.afterDrawing.delete(listener);
  }

  /** Adds a listener for movements of the camera, by the user or the page. */
  onMove(listener: () => void): void {
    this.afterMoving.push(listener);
  }

  /** Draws before the next frame is shown, once for any number of calls. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.drawNow();
    });
  }

  drawNow(): void {
    const far = this.camera.position.distanceTo(this.controls.target) + 4 * this.radius;
    this.camera.near = Math.max(0.05, far / 4000);
    this.camera.far = far * 2;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    for (const listener of this.afterDrawing) listener();
  }

  /**
   * Resolves when the next frame is drawn: without a graphics card that is long after it was asked
   * for.
   */
  async drawn(): Promise<void> {
    const frame = (): Promise<unknown> => new Promise(requestAnimationFrame);
    await frame();
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (fence && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await frame();
    gl.deleteSync(fence);
  }

  /** Makes the next box be looked at from the present side. */
  keepSide(): void {
    this.back = this.camera.position.clone().sub(this.controls.target).normalize();
  }

  /**
   * Looks from the south, half from above, or from the side that was kept, at points of the scene
   * (x, y, z one after the other) in a box; with some of what is around it, if there is much. The
   * camera stands as near as it can with all points in the window, which they fill in one
   * direction.
   */
  frame(points: readonly ArrayLike<number>[], box: Box3, around: Box3): void {
    this.setHome(points, box, around);
    this.goHome();
  }

  /** Makes such a view the one of `goHome`; the camera stays. */
  setHome(points: readonly ArrayLike<number>[], box: Box3, around: Box3): void {
    const middle = box.getCenter(new Vector3());
    const radius = Math.max(2, box.getSize(new Vector3()).length() / 2);
    this.radius = radius;
    this.controls.maxDistance = Math.max(radius * 12, around.getSize(new Vector3()).length());
    this.controls.minDistance = Math.min(0.5, radius / 20);
    const { back } = this;
    const right = new Vector3().crossVectors(UP, back).normalize();
    const above = new Vector3().crossVectors(back, right);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360) * (around.getSize(new Vector3()).length() > 3 * radius ? 0.68 : 0.9);
    const wide = tall * this.camera.aspect;
    // A point at depth z towards the camera is in the window if it lies less than (distance - z) *
    // wide from the middle line: the outermost ones of each side decide where that line is and how
    // far the camera.
    const most = { right: -Infinity, left: -Infinity, above: -Infinity, below: -Infinity, near: -Infinity };
    const at = new Vector3();
    for (const list of points) {
      for (let i = 0; i + 2 < list.length; i += 3) {
        at.set(list[i]!, list[i + 1]!, list[i + 2]!).sub(middle);
        const [x, y, z] = [at.dot(right), at.dot(above), at.dot(back)];
        most.right = Math.max(most.right, x + wide * z);
        most.left = Math.max(most.left, wide * z - x);
        most.above = Math.max(most.above, y + tall * z);
        most.below = Math.max(most.below, tall * z - y);
        most.near = Math.max(most.near, z);
      }
    }
    const aside = (most.right - most.left) / 2;
    const up = (most.above - most.below) / 2;
    const distance = Math.max((most.right + most.left) / (2 * wide), (most.above + most.below) / (2 * tall), most.near + radius / 10);
    const target = middle.addScaledVector(right, aside).addScaledVector(above, up);
    this.home = { position: target.clone().addScaledVector(back, distance), target };
  }

  goHome(): void {
    if (this.home) this.look(this.home.position, this.home.target);
  }

  look(position: Vector3, target: Vector3): void {
    this.camera.position.copy(position);
    this.controls.target.copy(target);
    this.controls.update();
    this.moved();
  }

  /** Sets the radius of the visible objects if a view is given and need not be framed. */
  setRadius(box: Box3): void {
    this.radius = Math.max(2, box.getSize(new Vector3()).length() / 2);
    this.controls.maxDistance = this.radius * 12;
  }

  /** Turns the camera round its target, radians. */
  orbit(aside: number, upwards: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const sphere = new Spherical().setFromVector3(new Vector3(offset.x, offset.z, -offset.y));
    sphere.theta += aside;
    sphere.phi = Math.min(this.controls.maxPolarAngle, Math.max(0.01, sphere.phi - upwards));
    const turned = new Vector3().setFromSpherical(sphere);
    this.look(this.controls.target.clone().add(new Vector3(turned.x, -turned.z, turned.y)), this.controls.target.clone());
  }

  /** Moves camera and target over the ground by shares of their distance. */
  pan(right: number, forward: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const ahead = new Vector3(-offset.x, -offset.y, 0);
    if (ahead.lengthSq() < 1e-9) ahead.set(0, 1, 0);
    ahead.normalize();
    const step = ahead.clone().multiplyScalar(forward).addScaledVector(new Vector3().crossVectors(ahead, UP), right).multiplyScalar(offset.length());
    this.look(this.camera.position.clone().add(step), this.controls.target.clone().add(step));
  }

  zoom(factor: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const length = Math.min(this.controls.maxDistance, Math.max(this.controls.minDistance, offset.length() * factor));
    this.look(this.controls.target.clone().add(offset.setLength(length)), this.controls.target.clone());
  }

  view(): View {
    const { camera } = this;
    camera.updateMatrixWorld();
    const window = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    return {
      target: this.controls.target.toArray(),
      isSeen: (middle, radius) => window.intersectsSphere(new Sphere(new Vector3(...middle), radius)),
    };
  }

  /** Returns the metres that a pixel of the page covers at the target. */
  metresPerPixel(): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360)) / Math.max(1, this.canvas.clientHeight);
  }

  /** Returns the direction in which the camera looks, degrees clockwise from +y. */
  heading(): number {
    const { position } = this.camera;
    const { target } = this.controls;
    return (Math.atan2(target.x - position.x, target.y - position.y) * 180) / Math.PI;
  }

  /** Returns the place of a point on the canvas in pixels of the page; null behind the camera. */
  project(point: Vector3): { x: number; y: number } | null {
    const seen = point.clone().project(this.camera);
    if (seen.z > 1 || Math.abs(seen.x) > 1 || Math.abs(seen.y) > 1) return null;
    return { x: ((seen.x + 1) / 2) * this.canvas.clientWidth, y: ((1 - seen.y) / 2) * this.canvas.clientHeight };
  }

  private moved(): void {
    for (const listener of this.afterMoving) listener();
    this.draw();
  }

  private resize(): void {
    const box = (this.canvas.parentElement ?? this.canvas).getBoundingClientRect();
    const [width, height] = [Math.max(1, Math.floor(box.width)), Math.max(1, Math.floor(box.height))];
    this.renderer.setPixelRatio(this.software ? 1 : Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.drawNow();
  }
}
