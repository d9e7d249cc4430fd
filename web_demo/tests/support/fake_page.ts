/** As much of a page as a collector of input needs, driven by the test. */

type Fields = Record<string, unknown>;

export class FakeElement extends EventTarget {
  tabIndex = -1;
  focused = 0;
  locked = 0;
  readonly captured: number[] = [];

  getBoundingClientRect(): object {
    return { left: 100, top: 50, width: 200, height: 100 };
  }

  focus(): void {
    this.focused += 1;
  }

  setPointerCapture(id: number): void {
    this.captured.push(id);
  }

  requestPointerLock(): Promise<void> {
    this.locked += 1;
    return Promise.resolve();
  }
}

export class FakeDocument extends EventTarget {
  visibilityState = "visible";
  pointerLockElement: EventTarget | null = null;
  focused = true;

  hasFocus(): boolean {
    return this.focused;
  }

  exitPointerLock(): void {
    this.pointerLockElement = null;
  }
}

/** An event with the fields of its kind. */
export function happen(target: EventTarget, name: string, fields: Fields = {}): Event {
  const event = new Event(name, { cancelable: true });
  Object.assign(event, fields);
  target.dispatchEvent(event);
  return event;
}

export class FakeGamepad {
  connected = true;
  mapping = "standard";
  axes = [0, 0, 0, 0];
  buttons: { value: number }[] = Array.from({ length: 17 }, () => ({ value: 0 }));
}
