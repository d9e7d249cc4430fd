/** The avatar's components that are not the standard's, as proxies; docs/reference/avatar.md says what they do. */

import { RoISCommon } from "../../sdk/index.ts";
import type { CompletedStatus } from "../../sdk/index.ts";
import type { Recognizer } from "./sent_to.ts";

const URN = "urn:x-rois:def:component:OpenRoIS::";

export interface Floor {
  /** Corners `x,y` in metres; empty for an unknown floor. */
  readonly outline: readonly string[];
  readonly obstacles: readonly (readonly string[])[];
}

/** Things and persons beside the figure, as parallel lists. */
export interface Things {
  readonly thing_ref: readonly string[];
  readonly kind: readonly string[];
  readonly name: readonly string[];
  /** Places `x,y,th`. */
  readonly position_data: readonly string[];
}

/** The floor, and everything on it. */
export class Surroundings extends RoISCommon {
  static readonly componentType = `${URN}Surroundings`;
  readonly figureMoved = this.event<{ readonly position_data: string }>("figure_moved", {
    position_data: "string",
  });
  readonly floorChanged = this.event<object>("floor_changed", {});
  readonly thingsChanged = this.event<object>("things_changed", {});

  floor(): Promise<Floor> {
    return this.query<Floor>("floor", { outline: "string[]", obstacles: "string[][]" });
  }

  things(): Promise<Things> {
    const texts = "string[]";
    return this.query<Things>("things", { thing_ref: texts, kind: texts, name: texts, position_data: texts });
  }
}

export interface WordSpoken {
  readonly speech_id: string;
  readonly word: string;
  /** Of its first character in the text, in Unicode code points. */
  readonly position: number;
  readonly length: number;
}

export interface SpeechBegan {
  readonly speech_id: string;
  readonly text: string;
  readonly is_ssml: boolean;
}

export interface SpeechEnded {
  readonly speech_id: string;
  readonly status: CompletedStatus;
  /** The last word that was begun, and where it stands in the text; none where no word was heard. */
  readonly word?: string;
  readonly position?: number;
}

/** Progress of speech, word by word. */
export class SpeechProgress extends RoISCommon<{ readonly barge_in?: boolean }> {
  static readonly componentType = `${URN}SpeechProgress`;
  protected override readonly parameterTypes = { barge_in: "bool" };
  readonly speechBegan = this.event<SpeechBegan>("speech_began", {
    speech_id: "string",
    text: "string",
    is_ssml: "bool",
  });
  readonly wordSpoken = this.event<WordSpoken>("word_spoken", {
    speech_id: "string",
    word: "string",
    position: "int",
    length: "int",
  });
  readonly speechEnded = this.event<SpeechEnded>("speech_ended", {
    speech_id: "string",
    status: "string",
    word: "string?",
    position: "int?",
  });

  /** Where texts are sent to be spoken, as `https://host`; empty where they stay with the body. */
  synthesizer(): Promise<{ readonly sent_to: string }> {
    return this.query<{ readonly sent_to: string }>("synthesizer", { sent_to: "string" });
  }
}

/** How the application that holds the voice converses. */
export interface Conversing {
  /** Where it sends words that it hears, as `https://host`; empty where they stay. */
  readonly sent_to: string;
  /** Examples. */
  readonly can_be_said: readonly string[];
  /** Begins each sentence to the body; empty: push to talk. */
  readonly wake_word: string;
}

/** What is said of the application that holds the voice, by itself. */
export class Dialogue extends RoISCommon<Partial<Conversing>> {
  static readonly componentType = `${URN}Dialogue`;
  protected override readonly parameterTypes = {
    sent_to: "string",
    can_be_said: "string[]",
    wake_word: "string",
  };
  readonly changed = this.event<Conversing>("changed", {
    sent_to: "string",
    can_be_said: "string[]",
    wake_word: "string",
  });
}

/** Persons in a picture of the camera, as parallel lists. */
export interface Seen {
  readonly person_ref: readonly string[];
  /** `left,top,width,height` in shares of the picture, not mirrored. */
  readonly box: readonly string[];
  readonly name: readonly string[];
  readonly gesture_ref: readonly string[];
  /** Whose camera it is, where visitors are told apart. */
  readonly visitor_ref?: string;
}

/** What the avatar sees of the visitor that it attends to. */
export class Sight extends RoISCommon {
  static readonly componentType = `${URN}Sight`;
  readonly seen = this.event<Seen>("seen", {
    person_ref: "string[]",
    box: "string[]",
    name: "string[]",
    gesture_ref: "string[]",
    visitor_ref: "string?",
  });
}

/** Persons that the avatar knows by name. */
export class Enrolment extends RoISCommon {
  static readonly componentType = `${URN}Enrolment`;

  /** Remembers the only person in front of the camera. */
  enrol(name: string): Promise<void> {
    return this.execute("enrol", [{ name: "name", data_type_ref: "string", value: name }]);
  }

  forget(name: string): Promise<void> {
    return this.execute("forget", [{ name: "name", data_type_ref: "string", value: name }]);
  }

  enrolled(): Promise<{ readonly names: readonly string[] }> {
    return this.query<{ readonly names: readonly string[] }>("enrolled", { names: "string[]" });
  }
}

/** Viewpoint of the pictures. */
export class Viewpoint extends RoISCommon {
  static readonly componentType = `${URN}Viewpoint`;
  readonly changed = this.event<{ readonly viewpoint: string }>("viewpoint_changed", { viewpoint: "string" });

  available(): Promise<{ readonly available_viewpoints: readonly string[] }> {
    return this.query<{ readonly available_viewpoints: readonly string[] }>("available_viewpoints", {
      available_viewpoints: "string[]",
    });
  }

  current(): Promise<{ readonly viewpoint: string }> {
    return this.query<{ readonly viewpoint: string }>("viewpoint", { viewpoint: "string" });
  }

  choose(viewpoint: string): Promise<void> {
    return this.execute("choose", [{ name: "viewpoint", data_type_ref: "string", value: viewpoint }]);
  }
}

/** Speech that the avatar has understood. */
export class Hearing extends RoISCommon {
  static readonly componentType = `${URN}Hearing`;
  readonly heard = this.event<{
    readonly text: string;
    readonly final: boolean;
    readonly visitor_ref?: string;
  }>("heard", { text: "string", final: "bool", visitor_ref: "string?" });

  recognizer(): Promise<Recognizer> {
    return this.query<Recognizer>("recognizer", { sent_to: "string", allowed: "bool" });
  }
}

/** What the avatar receives of its operator: levels of the microphone. */
export class Operator extends RoISCommon {
  static readonly componentType = `${URN}Operator`;
  readonly microphoneLevel = this.event<{
    readonly rms: number;
    readonly peak: number;
    readonly visitor_ref?: string;
  }>("microphone_level", { rms: "double", peak: "double", visitor_ref: "string?" });
}
