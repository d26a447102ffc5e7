// The current time and its controls: play, pause, slider, speed, steps of one sample.

import { byId, make } from "../dom.js";
import { decimals, duration, unitFor } from "../numbers.js";

const FACTORS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 50];
const NORMAL_SPEED = FACTORS.indexOf(1);
const SECONDS_PER_TURN = 4; // shown for one turn of the body at normal speed
const MIN_DURATION_S = 12; // of the whole span at normal speed, also for a body that hardly turns
const MAX_MARKS = 200;

export class Player {
  constructor(onTime) {
    this.onTime = onTime;
    this.slider = byId("time");
    this.button = byId("play");
    this.speed = byId("speed");
    this.playing = false;
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.slider.addEventListener("keydown", (event) => this.key(event));
    this.button.addEventListener("click", () => this.toggle());
    byId("back").addEventListener("click", () => this.step(-1));
    byId("forth").addEventListener("click", () => this.step(1));
    this.#paintButton();
  }

  show(ephemeris) {
    this.pause();
    this.ephemeris = ephemeris;
    this.unit = unitFor(Math.max(Math.abs(ephemeris.start), Math.abs(ephemeris.stop)));
    [this.slider.min, this.slider.max] = [ephemeris.start, ephemeris.stop];
    const turns = (ephemeris.meanRate * ephemeris.span) / (2 * Math.PI);
    this.normalRate = ephemeris.span / Math.max(MIN_DURATION_S, turns * SECONDS_PER_TURN);
    if (!ephemeris.connected) this.normalRate = ephemeris.span / (10 * MIN_DURATION_S);
    const chosen = this.speed.selectedIndex < 0 ? NORMAL_SPEED : this.speed.selectedIndex;
    this.speed.replaceChildren(...FACTORS.map((factor) => make("option", { value: factor }, this.#speedLabel(factor))));
    this.speed.selectedIndex = chosen;
    const marks = ephemeris.events.slice(0, MAX_MARKS).map((event) => this.#mark(event));
    byId("marks").replaceChildren(...marks);
    this.seek(ephemeris.start);
  }

  /** Marks windows [{start_s, stop_s}] beside the slider. */
  mark(windows) {
    const { start, span } = this.ephemeris;
    const part = (t) => (100 * (t - start)) / (span || 1);
    const bars = windows.slice(0, MAX_MARKS).map(({ start_s: from, stop_s: to }) => {
      const bar = make("span", {});
      bar.style.left = `${part(from).toFixed(3)}%`;
      bar.style.width = `${Math.max(0.15, part(to) - part(from)).toFixed(3)}%`;
      return bar;
    });
    byId("window-marks").replaceChildren(...bars);
  }

  seek(time) {
    const { ephemeris } = this;
    if (!ephemeris) return;
    this.time = Math.min(ephemeris.stop, Math.max(ephemeris.start, time));
    this.slider.value = this.time;
    const shown = this.text(this.time);
    const whole = this.text(ephemeris.stop);
    byId("clock").textContent = `${shown} / ${whole}`;
    this.slider.setAttribute("aria-valuetext", `${shown} of ${whole}`);
    this.onTime(this.time);
  }

  text(time) {
    const digits = decimals(this.ephemeris.span, this.unit);
    return `${(time / this.unit.seconds).toFixed(digits).replace("-", "−")} ${this.unit.name}`;
  }

  /** Moves by `count` samples; between two samples the first step goes to the neighbouring one. */
  step(count) {
    if (!this.ephemeris) return;
    this.pause();
    const here = this.ephemeris.index(this.time);
    const between = this.time > this.ephemeris.t[here];
    const target = count < 0 && between ? here + count + 1 : here + count;
    this.seek(this.ephemeris.t[Math.max(0, Math.min(this.ephemeris.length - 1, target))]);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (!this.ephemeris || !this.ephemeris.span) return;
    if (this.time >= this.ephemeris.stop) this.seek(this.ephemeris.start);
    this.playing = true;
    this.#paintButton();
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const elapsed = Math.min(0.25, Math.max(0, (now - last) / 1000)); // limited, because no frames are drawn while the page is hidden
      last = now;
      this.seek(this.time + elapsed * this.normalRate * Number(this.speed.value));
      if (this.time >= this.ephemeris.stop) this.pause();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    this.playing = false;
    this.#paintButton();
  }

  faster(steps) {
    const target = this.speed.selectedIndex + steps;
    this.speed.selectedIndex = Math.max(0, Math.min(FACTORS.length - 1, target));
  }

  /** Handles a key; returns whether it is one of the player. */
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const by = event.shiftKey ? 10 : 1;
    const keys = {
      ArrowLeft: () => this.step(-by),
      ArrowRight: () => this.step(by),
      Home: () => this.#end("start"),
      End: () => this.#end("stop"),
      " ": () => this.toggle(),
      "-": () => this.faster(-1),
      "+": () => this.faster(1),
      "=": () => this.faster(1),
    };
    const act = keys[event.key];
    if (!act) return false;
    event.preventDefault();
    event.stopPropagation();
    act();
    return true;
  }

  #end(which) {
    if (!this.ephemeris) return;
    this.pause();
    this.seek(this.ephemeris[which]);
  }

  #speedLabel(factor) {
    return `1 s shows ${duration(factor * this.normalRate, 2)}`;
  }

  #mark(event) {
    const part = (event.elapsed_s - this.ephemeris.start) / (this.ephemeris.span || 1);
    const mark = make("span", { title: event.text });
    mark.style.left = `${(100 * part).toFixed(3)}%`;
    return mark;
  }

  #paintButton() {
    this.button.classList.toggle("playing", this.playing);
    this.button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }
}
