// The page: starts the engine, opens what the page or its address names, and wires controls to it.

import { keepAddress, parseAddress } from "./address";
import { readOptions, takeBlock, takeLaterBlock } from "./blocks";
import { Legend } from "./colour/legend";
import { byId, download } from "./dom";
import type { Card } from "./card/card";
import { readPicture, type CloudPicture } from "./clouds";
import { csv, provenance } from "./download/csv";
import { picture } from "./download/picture";
import { Engine, type Group, type Site, type Source, type WeatherInfo } from "./engine/client";
import type { WeatherOptions } from "./engine/options";
import { knowsClearSkies } from "./light";
import { OpenedSite, type Page } from "./opened";
import { listenForFiles } from "./panel/files";
import { LightPanel } from "./panel/light";
import { Messages } from "./panel/messages";
import { PartsPanel } from "./panel/parts";
import { Player } from "./panel/play";
import { ShowPanel } from "./panel/show";
import { describe, describeWeather, tellOf } from "./panel/site";
import { readParts } from "./parts";
import { FIRST, comfortOf, isOfComfort } from "./people";
import { SurfacesPanel } from "./panel/surfaces";
import { listenToTabs } from "./panel/tabs";
import { VariantPanel } from "./panel/variant";
import { namesBeyond, nameOf, Session } from "./session";
import { DEFAULTS, isOfSun, isSum, Store, type State } from "./state";
import { listenToView } from "./view/keys";
import { Stage } from "./view/stage";

declare global {
  interface Window {
    /**
     * For automation and tests. `after` is the engine of the archive after, `card` the graphics
     * card's part. `ready`, asked at any time, resolves when the page shows the newest state or
     * reports a failure.
     */
    heliotile?: { readonly engine: Engine | null; readonly after: Engine | null; readonly card: Card | null; readonly state: Readonly<State>; readonly ready: Promise<void> };
  }
}

class Main {
  readonly store = new Store();
  readonly messages = new Messages();
  /** Resolves when the page shows the archive that it was opened with, or reports a failure. */
  started: Promise<void> = Promise.resolve();
  engine: Engine | null = null;
  /** Engine of the archive beside the first. */
  after: Engine | null = null;
  private given = parseAddress(location.hash);
  private readonly stage = new Stage(byId("view", HTMLCanvasElement));
  private readonly surfaces = new SurfacesPanel(this.store);
  private readonly page: Page;
  private readonly player: Player;
  private opened: OpenedSite | null = null;
  private keeping = false;
  private parts: PartsPanel | null = null;
  /** Chain of openings: archives are opened one after the other. */
  private opening: Promise<void> = Promise.resolve();
  /** Starts one more engine. */
  private startEngine: () => Promise<Engine> = () => Promise.reject(new Error("the engine has not started"));
  /** Number of the last archive that was asked for, and of the last one beside it. */
  private turn = 0;
  private turnBeside = 0;
  /** Reads the weather again, which an archive that is opened needs. */
  private weather: (engine: Engine) => Promise<WeatherInfo | null> = () => Promise.resolve(null);
  /** Picture of clouds, which every opened archive gets. */
  private picture: CloudPicture | null = null;

  constructor() {
    this.player = new Player(this.store, () => this.opened);
    this.page = {
      store: this.store,
      stage: this.stage,
      legend: new Legend(),
      messages: this.messages,
      show: new ShowPanel(this.store),
      light: new LightPanel(this.store, () => void (this.opening = this.removeClouds())),
      variant: new VariantPanel(this.store),
      playing: () => this.player.playing,
      say: (text) => (byId("live", HTMLElement).textContent = text),
      openTab: listenToTabs(),
    };
    listenToView(this.stage, (x, y) => this.opened?.pick(x, y));
    listenForFiles({
      onArchive: (file) => void this.anotherArchive(file),
      onAfter: (file) => void (this.opening = this.openAfter({ file })),
      onWeather: (file) => void this.anotherWeather(file),
      onClouds: (file) => void (this.opening = this.openClouds(file)),
    });
    addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.store.set({ selected: null, pinned: null });
    });
    byId("save-csv", HTMLButtonElement).addEventListener("click", () => void this.saveCsv());
    byId("save-picture", HTMLButtonElement).addEventListener("click", () => void this.savePicture());
    byId("go-home", HTMLButtonElement).addEventListener("click", () => this.stage.goHome());
    this.stage.onMove(() => {
      if (!this.opened) return;
      const { camera, controls } = this.stage;
      this.store.set({ camera: [...camera.position.toArray(), ...controls.target.toArray()] });
    });
  }

  async start(): Promise<void> {
    const [engine, worker] = await Promise.all([takeBlock("engine"), takeBlock("worker")]);
    if (!engine || !worker) throw new Error("this page was built without its engine");
    const address = URL.createObjectURL(new Blob([worker.bytes], { type: "text/javascript" }));
    const module = await WebAssembly.compile(engine.bytes);
    const options = readOptions();
    this.startEngine = async () => {
      const engine = await Engine.start(address, module, options.workers);
      engine.onLost = (error) => this.messages.error("running one of several workers (the others continue)", error);
      return engine;
    };
    this.engine = await this.startEngine();
    const [archive, weather] = [await takeBlock("archive"), await takeBlock("weather")];
    const local = location.protocol === "file:";
    const source: Source | null = archive ? archive : options.archive && !local ? { url: options.archive } : null;
    const beside = async (): Promise<Source | null> => (await takeLaterBlock("after")) ?? (options.after && !local ? { url: options.after } : null);
    const outside = options.archive ?? options.parts;
    if (!source && (local || !outside)) {
      byId("welcome", HTMLElement).hidden = false;
      if (outside) this.messages.tell([`A page opened from a file cannot load ${outside} by itself: open ${options.archive ? "it" : "an archive"} here.`], false);
      return;
    }
    this.weather = async (engine) => {
      try {
        if (weather) return await engine.loadWeather(weather.name, weather.bytes, options.weatherOptions);
        if (options.weather && !local) return await fetchWeather(engine, options.weather, options.weatherOptions, options.weatherName);
      } catch (error) {
        this.messages.error("reading the weather", error);
      }
      return null;
    };
    await (source ? this.open(source, null, beside) : this.openParts(outside ?? ""));
  }

  /**
   * Shows the parts of an atlas: first the one in the address, or else the first that is built;
   * later those that the user chooses.
   */
  private async openParts(address: string): Promise<void> {
    const parts = await readParts(address);
    this.parts = new PartsPanel(parts, (part) => {
      this.stage.keepSide();
      this.store.set({ part, camera: null, selected: null, pinned: null });
    });
    const { part: wished } = this.given;
    const first = parts.find(({ name, archive }) => archive !== null && name === wished) ?? parts.find(({ archive }) => archive !== null);
    if (!first) throw new Error("no part of this atlas is built");
    if (wished !== undefined && wished !== first.name) this.messages.tell([`Part ${wished} of this atlas does not exist or is not built. The page shows part ${first.name}.`], false);
    this.given.part = first.name;
    this.store.subscribe((changed) => {
      if (changed.has("part")) this.opening = this.openPart();
    });
    this.store.set({ part: first.name });
    await this.opening;
  }

  /** Opens the part of the state. Settings stay as they are if that part can show them. */
  private async openPart(): Promise<void> {
    const { part } = this.store.state;
    const url = this.parts?.parts.find(({ name }) => name === part)?.archive;
    if (part === null || !url) {
      this.parts?.mark(null);
      if (part !== null) this.messages.tell([`Part ${part} of this atlas does not exist or is not built.`], false);
      return;
    }
    this.parts?.mark(part);
    if (this.opened) this.given = { ...this.store.state };
    await this.open({ url }, part);
  }

  get card(): Card | null {
    return this.opened?.before.asker.card ?? null;
  }

  async settled(): Promise<void> {
    await this.started;
    await this.opening;
    await this.opened?.settled();
  }

  /**
   * Opens an archive in place of those that are open, and another beside it; a part is called by
   * its name.
   */
  private async open(source: Source, part: string | null = null, beside: () => Promise<Source | null> = () => Promise.resolve(null)): Promise<void> {
    const { engine } = this;
    if (!engine) return;
    const turn = ++this.turn;
    byId("welcome", HTMLElement).hidden = true;
    const name = part ?? addressOf(source);
    let site: Site;
    try {
      site = await engine.open(source);
      if (part !== null) site = { ...site, name: part };
    } catch (error) {
      // A newer request for an archive supersedes this one.
      if (turn !== this.turn) return;
      this.messages.error(`opening ${name}`, error);
      byId("welcome", HTMLElement).hidden = this.opened !== null;
      return;
    }
    this.opened?.close();
    this.opened = null;
    this.closeAfter();
    const session = new Session(engine, site);
    describe(site);
    this.store.set({ ...this.fallbacks(site), ...this.sensible(site) });
    await session.takeClouds(this.picture);
    if (turn !== this.turn) return;
    this.opened = new OpenedSite(this.page, session);
    document.body.dataset["state"] = "open";
    this.surfaces.open(site);
    this.page.show.open(session);
    this.page.light.open(session);
    if (!this.keeping) keepAddress(this.store);
    this.keeping = true;
    // Weather is read first if the address needs it; else the picture comes first.
    const found = this.weather(engine);
    const reading = this.opened.read();
    const people = session.readPeople();
    const weather = await found;
    await people;
    if (turn !== this.turn) return;
    this.takePeople(session);
    this.takeWeather(weather);
    // The archive beside it comes when the first is on the screen.
    await reading;
    const other = turn === this.turn ? await beside() : null;
    if (other && turn === this.turn) await this.openAfter(other);
    await this.opened.settled();
  }

  /** Opens an archive beside the first; one that was there goes. */
  private async openAfter(source: Source): Promise<void> {
    const { opened } = this;
    if (!opened) return;
    const { site: before } = opened.session;
    const turn = ++this.turnBeside;
    const name = addressOf(source);
    const engine = await this.startEngine();
    try {
      const site = await engine.open(source, { place: before.place });
      const weather = opened.session.weather && (await this.weather(engine));
      if (turn !== this.turnBeside) return engine.close();
      opened.dropAfter();
      this.after?.close();
      this.after = engine;
      const session = new Session(engine, site, opened.session);
      session.weather = weather;
      await session.readPeople();
      await session.takeClouds(this.picture);
      if (turn !== this.turnBeside) return engine.close();
      [session.foreign, opened.session.foreign] = [namesBeyond(before, site), namesBeyond(site, before)];
      this.takeChanges(site, opened.session);
      this.surfaces.open(before, site);
      describe(before, site);
      if (weather) describeWeather(weather);
      const partners = await opened.compareWith(session);
      if (!session.closed) tellOf(partners, before, site, this.messages);
    } catch (error) {
      if (turn !== this.turnBeside) return engine.close();
      this.messages.error(`opening ${name}`, error);
      if (this.after !== engine) engine.close();
    }
  }

  private closeAfter(): void {
    this.turnBeside += 1;
    this.after?.close();
    this.after = null;
  }

  /** Changes that the address gives to what only the archive after has. */
  private takeChanges(after: Site, { foreign }: Session): void {
    const known = this.knownChanges(after);
    const { state } = this.store;
    const only = (kind: Group["kind"], changes: State["reflectance"] = {}): State["reflectance"] =>
      Object.fromEntries(Object.entries(changes).filter(([name]) => foreign.has(nameOf({ kind, name }))));
    const reflectance = { ...only("opaque", known.reflectance), ...state.reflectance };
    this.store.set({ reflectance, transmittance: { ...only("canopy", known.transmittance), ...state.transmittance } });
  }

  /** Returns values that this archive can show, for a state that the address does not set. */
  private fallbacks(site: Site): Partial<State> {
    const clear = this.engine !== null && knowsClearSkies(this.engine) && site.place !== null;
    return {
      show: site.hasReference ? "reference" : "sky",
      sunBy: site.place ? "clock" : "angles",
      light: clear ? "clear" : "own",
    };
  }

  /** Returns the state of the address, without the parts that this archive does not have. */
  private sensible(site: Site): Partial<State> {
    const given = { ...this.given };
    if (given.component !== undefined && !site.components.includes(given.component) && !isOfComfort(given.component)) delete given.component;
    if (given.sky !== undefined && !site.skies.includes(given.sky)) delete given.sky;
    if (given.show === "reference" && !site.hasReference) delete given.show;
    if (given.show !== undefined && isOfSun(given.show) && !site.place) delete given.show;
    if (given.show === "glare" && !site.materials.some(({ mirror }) => mirror)) delete given.show;
    return { ...given, ...this.knownChanges(site) };
  }

  /** Changes that the address gives to what this archive has. */
  private knownChanges(site: Site): Partial<State> {
    const found: Partial<State> = {};
    for (const key of ["reflectance", "transmittance"] as const) {
      const known = new Set(site.groups.filter((group) => (group.kind === "canopy") === (key === "transmittance")).map(({ name }) => name));
      const changes = this.given[key];
      if (changes) found[key] = Object.fromEntries(Object.entries(changes).filter(([name]) => known.has(name)));
    }
    return found;
  }

  /** Shows the comfort of people, if the address does not ask for something else. */
  private takePeople({ people }: Session): void {
    const { state } = this.store;
    if (people && this.given.show === undefined && this.given.component === undefined) {
      [this.given.show, this.given.component] = ["moment", FIRST];
      this.store.set({ show: "moment", component: FIRST });
    }
    if (!people && isOfComfort(state.component)) this.store.set({ component: DEFAULTS.component });
    this.opened?.takePeople();
  }

  private takeWeather(weather: WeatherInfo | null): void {
    const { opened } = this;
    if (!opened) return;
    opened.session.weather = weather;
    if (!weather) {
      if (isSum(this.store.state.show)) this.store.set({ show: opened.session.site.hasReference ? "reference" : "sky" });
      if (this.store.state.light === "weather") this.store.set({ light: this.fallbacks(opened.session.site).light ?? "own" });
      opened.renew();
      return;
    }
    describeWeather(weather);
    if (weather.warnings.length > 0) this.messages.tell(weather.warnings.slice(0, 3), false, "weather");
    // The view that the address gives stays as it is.
    const changes: Partial<State> = {};
    if (this.given.light === undefined && this.given.sunBy === undefined) [changes.sunBy, changes.light] = ["clock", "weather"];
    if (this.given.show === undefined && this.store.state.show !== "moment") [changes.show, changes.range] = ["year", this.given.range ?? null];
    this.store.set(changes);
    opened.renew();
  }

  private async anotherArchive(file: File): Promise<void> {
    this.messages.clear();
    if (this.opened) {
      // The address belongs to the former archive.
      this.given = {};
      this.store.set({ ...DEFAULTS });
    }
    this.weather = () => Promise.resolve(null);
    this.picture = null;
    await this.open({ file });
  }

  private async anotherWeather(file: File): Promise<void> {
    if (!this.opened) {
      this.messages.tell(["Open an archive first, then its weather."], false);
      return;
    }
    try {
      delete this.given.show;
      delete this.given.light;
      const weather = async (engine: Engine): Promise<WeatherInfo> => engine.loadWeather(file.name, await file.arrayBuffer());
      const { before, after } = this.opened;
      if (after) after.session.weather = await weather(after.session.engine);
      this.takeWeather(await weather(before.session.engine));
      this.weather = weather;
    } catch (error) {
      this.messages.error(`reading ${file.name}`, error);
    }
  }

  /** Puts a picture of clouds before the sky, in place of the former. */
  private async openClouds(file: File): Promise<void> {
    if (!this.opened) {
      this.messages.tell(["Open an archive first, then clouds."], false);
      return;
    }
    try {
      await this.takeClouds(await readPicture(file));
      this.page.light.turnClouds(this.store.state.clouds ?? 0);
    } catch (error) {
      this.messages.error(`reading ${file.name}`, error);
    }
  }

  private async removeClouds(): Promise<void> {
    this.store.set({ clouds: null });
    await this.takeClouds(null);
  }

  private async takeClouds(picture: CloudPicture | null): Promise<void> {
    this.picture = picture;
    await Promise.all((this.opened?.layers ?? []).map(({ session }) => session.takeClouds(picture)));
    this.opened?.renew();
  }

  private async saveCsv(): Promise<void> {
    const { opened } = this;
    if (!opened) return;
    const button = byId("save-csv", HTMLButtonElement);
    button.disabled = true;
    try {
      await this.settled();
      const blob = await csv({ ...this.store.state }, opened, (share) => {
        button.textContent = share < 1 ? `Save CSV (${Math.round(100 * share)} %)` : "Save CSV";
      });
      download(blob, `${this.baseName()}.csv`);
    } catch (error) {
      this.messages.error("writing the CSV", error);
    }
    button.textContent = "Save CSV";
    button.disabled = false;
  }

  private async savePicture(): Promise<void> {
    const { opened, stage } = this;
    if (!opened) return;
    stage.drawNow();
    try {
      const lines = provenance(this.store.state, opened);
      download(await picture(stage.canvas, stage.renderer.getPixelRatio(), this.page.legend.shown, lines), `${this.baseName()}.png`);
    } catch (error) {
      this.messages.error("drawing the picture", error);
    }
  }

  private baseName(): string {
    const { state } = this.store;
    const name = this.opened?.session.site.name.replace(/\.helio$/, "") ?? "site";
    const variant = this.opened?.after ? `.${this.opened.variant}` : "";
    return `${name}${variant}.${state.show}${state.show === "moment" || isSum(state.show) ? `.${comfortOf(state, this.opened?.session.people ?? null) ?? state.component}` : ""}`;
  }
}

async function fetchWeather(engine: Engine, url: string, read: WeatherOptions, name?: string): Promise<WeatherInfo> {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: the server answers ${answer.status}`);
  return engine.loadWeather(name ?? new URL(answer.url).pathname.split("/").pop() ?? url, await answer.arrayBuffer(), read);
}

function addressOf(source: Source): string {
  return "url" in source ? source.url : "file" in source ? source.file.name : source.name;
}

function begin(): Main {
  try {
    return new Main();
  } catch (error) {
    new Messages().tell([`This page needs WebGL 2, which this browser does not provide: ${error instanceof Error ? error.message : String(error)}`, "Allow graphics acceleration, or use a newer browser."], true, "webgl");
    throw error;
  }
}

const main = begin();
main.started = main.start().catch((error: unknown) => main.messages.error("starting the page", error));
window.heliotile = {
  get engine() {
    return main.engine;
  },
  get after() {
    return main.after;
  },
  get card() {
    return main.card;
  },
  state: main.store.state,
  get ready() {
    return main.settled();
  },
};
