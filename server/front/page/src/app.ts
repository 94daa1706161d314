// The page: connects, shows one device, and keeps asking what a stream of states does not tell.

import { ClientError, type Device, type DeviceState } from "hapticd";
import { at, say } from "./dom";
import type { Source } from "./live_source";
import { Access } from "./panels/access";
import { Actions } from "./panels/actions";
import { Chooser } from "./panels/chooser";
import { Events } from "./panels/events";
import { showJoints } from "./panels/joints";
import { showServer } from "./panels/server";
import { showSessions } from "./panels/sessions";
import { Stage } from "./panels/stage";
import { StateCard } from "./panels/state_card";
import { Stop } from "./panels/stop";
import { Traces } from "./traces/traces";

const POLL_MS = 1000;
/** Without a state for so long the picture is said to be old. */
const OLD_MS = 1000;
const WORDS_MS = 100; // texts change no faster than people read

export class App {
  private source: Source;
  private device: Device | null = null;
  private watching: { close(): void } | null = null;
  private newest: DeviceState | null = null;
  private stateAt = 0;
  private wordsAt = 0;
  private states = 0; // since countedAt
  private countedAt = 0;
  private asking = false;

  private readonly current = () => this.source;
  private readonly access = new Access((token) => this.useToken(token));
  private readonly chooser = new Chooser((name) => void this.choose(name));
  private readonly stage = new Stage();
  private readonly card = new StateCard();
  private readonly stop = new Stop(this.current);
  private readonly actions = new Actions(this.current);
  private readonly traces = new Traces();
  private readonly events = new Events();

  /** `open`: connects with a token, or, without one, with what the browser has. */
  constructor(private readonly open: (token?: string) => Source) {
    this.source = open();
    void this.poll();
    setInterval(() => void this.poll(), POLL_MS);
  }

  private async useToken(token: string): Promise<void> {
    const source = this.open(token);
    await source.devices();
    this.source = source;
    this.actions.rights(null);
    this.leave();
    await this.poll();
  }

  private async choose(name: string): Promise<void> {
    if (this.device?.name === name) return;
    this.leave();
    await this.poll();
  }

  /** Once per second; also what brings a lost stream back. */
  private async poll(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    const { source } = this;
    try {
      const devices = await source.devices();
      if (source !== this.source) return;
      if (!this.watching) await this.enter(devices);
      const device = devices.find(({ name }) => name === this.device?.name);
      if (device) this.device = device; // who controls it may have changed
      const [info, links] = await Promise.all([source.serverInfo(), source.links()]);
      if (this.device) {
        showServer(info, this.device);
        showSessions(links, this.device.name);
      }
      this.traces.server(info);
      this.trouble("");
    } catch (error) {
      this.refused(error);
    } finally {
      this.asking = false;
      this.connection();
    }
  }

  private async enter(devices: readonly Device[]): Promise<void> {
    const device = this.chooser.offer(devices);
    if (!device) return;
    const same = this.device?.name === device.name;
    this.device = device;
    this.access.close();
    at("live").hidden = false;
    if (!same) this.events.show();
    this.stage.show(device);
    this.card.show();
    this.actions.show(device);
    if (same) this.traces.cut();
    else this.traces.show(device);
    this.watching = this.source.watch(device.name, {
      state: (state) => this.take(state),
      event: (event) => this.events.add(event),
      ended: (error) => {
        this.watching = null;
        this.refused(error);
        this.connection();
      },
    });
    this.actions.rights(await this.source.mayControl(device.name));
  }

  private leave(): void {
    this.watching?.close();
    this.watching = null;
    this.newest = null;
  }

  private take(state: DeviceState): void {
    const { device } = this;
    if (!device) return;
    const now = performance.now();
    const changed = state.state !== this.newest?.state || state.faults !== this.newest.faults;
    this.newest = state;
    this.stateAt = now;
    this.states++;
    this.traces.state(state);
    this.stage.state(state);
    if (state.faults === 0) this.stop.over();
    if (!changed && now - this.wordsAt < WORDS_MS) return;
    this.wordsAt = now;
    this.card.state(device, state);
    showJoints(device, state);
    this.actions.state(device, state);
  }

  private refused(error: unknown): void {
    if (error instanceof ClientError && error.code === "unauthenticated") {
      this.leave();
      at("live").hidden = true;
      this.access.open(false);
      return this.trouble("");
    }
    const words = error instanceof Error ? error.message : String(error);
    if (this.isLive()) {
      return this.trouble(`The server answers slowly: ${words}. The picture is live.`);
    }
    const again = this.newest ? "What you see is old. " : "";
    this.trouble(`No connection to the server: ${words}. ${again}Trying again …`);
  }

  private trouble(text: string): void {
    say(at("trouble"), text);
    at("trouble").hidden = text === "";
  }

  /** States come: whatever else fails, what is shown is new. */
  private isLive(): boolean {
    return this.watching !== null && performance.now() - this.stateAt <= OLD_MS;
  }

  private connection(): void {
    const now = performance.now();
    const live = this.isLive();
    const rate = Math.round((this.states * 1000) / Math.max(now - this.countedAt, 1));
    this.countedAt = now;
    at("live").classList.toggle("old", !live);
    say(at("connection"), live ? `Live · ${rate} states per second` : "Not connected");
    this.states = 0;
  }
}
