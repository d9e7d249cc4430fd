/** The component types of the catalog: what their messages carry, and a proxy for each. Written by `make generate`; edits are lost. */

import { ComponentProxy, encode } from "../component.ts";
import type { Types } from "../component.ts";
import type { ComponentStatus, StreamStatus } from "./types.ts";

/** What a component is able to do now. */
export interface ComponentStatusResult {
  /** the component's status */
  readonly status: ComponentStatus;
}
const COMPONENT_STATUS_RESULT: Types<ComponentStatusResult> = { status: "Component_Status" };

/** Messages shared by the basic components. */
export class RoISCommon<
  Parameters extends object = object,
  ReadOnly extends keyof Parameters = never,
> extends ComponentProxy<Parameters, ReadOnly> {
  /** Begin what the component is for. */
  start(): Promise<void> {
    return this.execute("start");
  }

  /** End it. */
  stop(): Promise<void> {
    return this.execute("stop");
  }

  /** Pause it. */
  suspend(): Promise<void> {
    return this.execute("suspend");
  }

  /** Go on with it. */
  resume(): Promise<void> {
    return this.execute("resume");
  }

  /** Ask what the component is able to do now. */
  componentStatus(condition?: string): Promise<ComponentStatusResult> {
    return this.query("component_status", COMPONENT_STATUS_RESULT, condition);
  }
}

/** Where the robot, its sensors and its actuators are; the lists run in parallel. */
export interface RobotPositionResult {
  /** a position x,y,th for each ref */
  readonly position_data: readonly string[];
  /** whose positions they are */
  readonly robot_ref: readonly string[];
  /** when they were measured */
  readonly timestamp: Date;
}
const ROBOT_POSITION_RESULT: Types<RobotPositionResult> = {
  position_data: "String[]",
  robot_ref: "RoISIdentifier[]",
  timestamp: "DateTime",
};

/** Whether the engine works. */
export interface EngineStatusResult {
  /** the engine's status */
  readonly status: ComponentStatus;
  /** when it can be used */
  readonly operable_time?: Date;
}
const ENGINE_STATUS_RESULT: Types<EngineStatusResult> = {
  status: "Component_Status",
  operable_time: "DateTime?",
};

/** Where the robot is and whether its engine works; mandatory where the engine is a physical unit. */
export class SystemInformation extends ComponentProxy {
  static readonly componentType = "urn:x-rois:def:component:OMG::SystemInformation";

  /** Ask where the robot and its parts are. */
  robotPosition(condition?: string): Promise<RobotPositionResult> {
    return this.query("robot_position", ROBOT_POSITION_RESULT, condition);
  }

  /** Ask whether the engine works. */
  engineStatus(condition?: string): Promise<EngineStatusResult> {
    return this.query("engine_status", ENGINE_STATUS_RESULT, condition);
  }
}

/** The number of persons has changed. */
export interface PersonDetected {
  /** how many there are now */
  readonly number: number;
  /** when it was measured */
  readonly timestamp: Date;
}
const PERSON_DETECTED: Types<PersonDetected> = { number: "int", timestamp: "DateTime" };

/** Tells how many persons there are. */
export class PersonDetection extends RoISCommon {
  static readonly componentType = "urn:x-rois:def:component:OMG::PersonDetection";

  /** The number of persons has changed. */
  readonly personDetected = this.event("person_detected", PERSON_DETECTED);
}

/** Where persons are; the lists run in parallel. */
export interface PersonLocalized {
  /** who or what they are, with reference information */
  readonly person_ref: readonly string[];
  /** when it was measured */
  readonly timestamp: Date;
  /** a position x,y,th for each ref */
  readonly position_data: readonly string[];
}
const PERSON_LOCALIZED: Types<PersonLocalized> = {
  person_ref: "RoISIdentifier[]",
  timestamp: "DateTime",
  position_data: "String[]",
};

/** When to tell that something has moved. */
export interface LocalizationParameters {
  /** tell of movements of more than this many millimetres */
  readonly detection_threshold?: number;
  /** tell at most once in this many milliseconds */
  readonly minimum_interval?: number;
}
const LOCALIZATION_PARAMETERS: Types<LocalizationParameters> = {
  detection_threshold: "int",
  minimum_interval: "int",
};

/** Tells where persons are. */
export class PersonLocalization extends RoISCommon<LocalizationParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::PersonLocalization";
  protected override readonly parameterTypes = LOCALIZATION_PARAMETERS;

  /** Persons have moved. */
  readonly personLocalized = this.event("person_localized", PERSON_LOCALIZED);
}

/** Who is there. */
export interface PersonIdentified {
  /** who or what they are, with reference information */
  readonly person_ref: readonly string[];
  /** when it was measured */
  readonly timestamp: Date;
}
const PERSON_IDENTIFIED: Types<PersonIdentified> = { person_ref: "RoISIdentifier[]", timestamp: "DateTime" };

/** Tells who is there. */
export class PersonIdentification extends RoISCommon {
  static readonly componentType = "urn:x-rois:def:component:OMG::PersonIdentification";

  /** Persons were recognised. */
  readonly personIdentified = this.event("person_identified", PERSON_IDENTIFIED);
}

/** The number of faces has changed. */
export interface FaceDetected {
  /** how many there are now */
  readonly number: number;
  /** when it was measured */
  readonly timestamp: Date;
}
const FACE_DETECTED: Types<FaceDetected> = { number: "int", timestamp: "DateTime" };

/** Tells how many faces there are. */
export class FaceDetection extends RoISCommon {
  static readonly componentType = "urn:x-rois:def:component:OMG::FaceDetection";

  /** The number of faces has changed. */
  readonly faceDetected = this.event("face_detected", FACE_DETECTED);
}

/** Where faces are; the lists run in parallel. */
export interface FaceLocalized {
  /** who or what they are, with reference information */
  readonly face_ref: readonly string[];
  /** when it was measured */
  readonly timestamp: Date;
  /** a position x,y,th for each ref */
  readonly position_data: readonly string[];
}
const FACE_LOCALIZED: Types<FaceLocalized> = {
  face_ref: "RoISIdentifier[]",
  timestamp: "DateTime",
  position_data: "String[]",
};

/** Tells where faces are. */
export class FaceLocalization extends RoISCommon<LocalizationParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::FaceLocalization";
  protected override readonly parameterTypes = LOCALIZATION_PARAMETERS;

  /** Faces have moved. */
  readonly faceLocalized = this.event("face_localized", FACE_LOCALIZED);
}

/** The number of sound sources has changed; 0 or 1 where sources cannot be told apart. */
export interface SoundDetected {
  /** how many there are now */
  readonly number: number;
  /** when it was measured */
  readonly timestamp: Date;
}
const SOUND_DETECTED: Types<SoundDetected> = { number: "int", timestamp: "DateTime" };

/** Tells how many sound sources there are. */
export class SoundDetection extends RoISCommon {
  static readonly componentType = "urn:x-rois:def:component:OMG::SoundDetection";

  /** The number of sound sources has changed. */
  readonly soundDetected = this.event("sound_detected", SOUND_DETECTED);
}

/** Where sounds come from; the lists run in parallel. */
export interface SoundLocalized {
  /** who or what they are, with reference information */
  readonly sound_ref: readonly string[];
  /** when it was measured */
  readonly timestamp: Date;
  /** a position x,y,th for each ref */
  readonly position_data: readonly string[];
}
const SOUND_LOCALIZED: Types<SoundLocalized> = {
  sound_ref: "RoISIdentifier[]",
  timestamp: "DateTime",
  position_data: "String[]",
};

/** Tells where sounds come from. */
export class SoundLocalization extends RoISCommon<LocalizationParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::SoundLocalization";
  protected override readonly parameterTypes = LOCALIZATION_PARAMETERS;

  /** Sound sources have moved. */
  readonly soundLocalized = this.event("sound_localized", SOUND_LOCALIZED);
}

/** The languages that can be recognised. */
export interface RecognizableLanguagesResult {
  /** ISO 639-1 codes */
  readonly languages: readonly string[];
}
const RECOGNIZABLE_LANGUAGES_RESULT: Types<RecognizableLanguagesResult> = { languages: "string[]" };

/** A person began to speak. */
export interface SpeechInputStarted {
  /** when it was measured */
  readonly timestamp: Date;
}
const SPEECH_INPUT_STARTED: Types<SpeechInputStarted> = { timestamp: "DateTime" };

/** A person stopped speaking. */
export interface SpeechInputFinished {
  /** when it was measured */
  readonly timestamp: Date;
}
const SPEECH_INPUT_FINISHED: Types<SpeechInputFinished> = { timestamp: "DateTime" };

/** What was said. */
export interface SpeechRecognized {
  /** what may have been said, the likeliest first */
  readonly recognized_text: readonly string[];
  /** when it was measured */
  readonly timestamp: Date;
}
const SPEECH_RECOGNIZED: Types<SpeechRecognized> = { recognized_text: "string[]", timestamp: "DateTime" };

/** What speech to expect. */
export interface SpeechRecognitionParameters {
  /** ISO 639-1 codes */
  readonly languages?: readonly string[];
  /** the grammar to use */
  readonly grammar?: string;
  /** the grammar's rule to begin with */
  readonly rule?: string;
}
const SPEECH_RECOGNITION_PARAMETERS: Types<SpeechRecognitionParameters> = {
  languages: "string[]",
  grammar: "string",
  rule: "string",
};

/** Writes down what is said. */
export class SpeechRecognition extends RoISCommon<SpeechRecognitionParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::SpeechRecognition";
  protected override readonly parameterTypes = SPEECH_RECOGNITION_PARAMETERS;

  /** Ask which languages it can be set to recognise. */
  recognizableLanguages(condition?: string): Promise<RecognizableLanguagesResult> {
    return this.query("recognizable_languages", RECOGNIZABLE_LANGUAGES_RESULT, condition);
  }

  /** A person began to speak. */
  readonly speechInputStarted = this.event("speech_input_started", SPEECH_INPUT_STARTED);

  /** A person stopped speaking. */
  readonly speechInputFinished = this.event("speech_input_finished", SPEECH_INPUT_FINISHED);

  /** Something was said. */
  readonly speechRecognized = this.event("speech_recognized", SPEECH_RECOGNIZED);
}

/** A gesture was made. */
export interface GestureRecognized {
  /** who or what they are, with reference information */
  readonly gesture_ref: readonly string[];
  /** when it was measured */
  readonly timestamp: Date;
}
const GESTURE_RECOGNIZED: Types<GestureRecognized> = {
  gesture_ref: "RoISIdentifier[]",
  timestamp: "DateTime",
};

/** What gestures can be recognised. */
export interface GestureRecognitionParameters {
  /** the gestures it knows; read only */
  readonly recognizable_gestures?: readonly string[];
}
const GESTURE_RECOGNITION_PARAMETERS: Types<GestureRecognitionParameters> = {
  recognizable_gestures: "RoISIdentifier[]",
};

/** Tells which gestures are made. */
export class GestureRecognition extends RoISCommon<GestureRecognitionParameters, "recognizable_gestures"> {
  static readonly componentType = "urn:x-rois:def:component:OMG::GestureRecognition";
  protected override readonly parameterTypes = GESTURE_RECOGNITION_PARAMETERS;

  /** A gesture was made. */
  readonly gestureRecognized = this.event("gesture_recognized", GESTURE_RECOGNIZED);
}

/** The languages that can be spoken. */
export interface SynthesizableLanguagesResult {
  /** ISO 639-1 codes */
  readonly languages: readonly string[];
}
const SYNTHESIZABLE_LANGUAGES_RESULT: Types<SynthesizableLanguagesResult> = { languages: "string[]" };

/** The voices that can speak. */
export interface AvailableVoicesResult {
  /** names of voices */
  readonly characters: readonly string[];
}
const AVAILABLE_VOICES_RESULT: Types<AvailableVoicesResult> = { characters: "string[]" };

/** What to say and how: plain text or SSML, one of the two. */
export interface SpeechSynthesisParameters {
  /** the text to speak */
  readonly speech_text?: string;
  /** the SSML to speak; unknown tags are skipped */
  readonly ssml_text?: string;
  /** how loud, 0 to 100 */
  readonly volume?: number;
  /** ISO 639-1 code */
  readonly language?: string;
  /** the voice's name, as in available_voices */
  readonly character?: string;
}
const SPEECH_SYNTHESIS_PARAMETERS: Types<SpeechSynthesisParameters> = {
  speech_text: "string",
  ssml_text: "string",
  volume: "int",
  language: "string",
  character: "string",
};

/** Speaks a text; `start` is completed when it has been spoken. */
export class SpeechSynthesis extends RoISCommon<SpeechSynthesisParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::SpeechSynthesis";
  protected override readonly parameterTypes = SPEECH_SYNTHESIS_PARAMETERS;

  /** Ask which languages it speaks. */
  synthesizableLanguages(condition?: string): Promise<SynthesizableLanguagesResult> {
    return this.query("synthesizable_languages", SYNTHESIZABLE_LANGUAGES_RESULT, condition);
  }

  /** Ask which voices it has. */
  availableVoices(condition?: string): Promise<AvailableVoicesResult> {
    return this.query("available_voices", AVAILABLE_VOICES_RESULT, condition);
  }
}

/** The reactions that can be played. */
export interface AvailableReactionsResult {
  /** refs of reactions */
  readonly available_reactions: readonly string[];
}
const AVAILABLE_REACTIONS_RESULT: Types<AvailableReactionsResult> = {
  available_reactions: "RoISIdentifier[]",
};

/** Which reaction to play. */
export interface ReactionParameters {
  /** the reaction to play */
  readonly reaction_ref?: string;
}
const REACTION_PARAMETERS: Types<ReactionParameters> = { reaction_ref: "RoISIdentifier" };

/** Plays a reaction, such as a nod. */
export class Reaction extends RoISCommon<ReactionParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::Reaction";
  protected override readonly parameterTypes = REACTION_PARAMETERS;

  /** Ask which reactions it can play. */
  availableReactions(condition?: string): Promise<AvailableReactionsResult> {
    return this.query("available_reactions", AVAILABLE_REACTIONS_RESULT, condition);
  }
}

/** A position of the route was reached. */
export interface ReachedTarget {
  /** the position */
  readonly target: string;
  /** whether it is the last one */
  readonly is_final_target: boolean;
}
const REACHED_TARGET: Types<ReachedTarget> = { target: "string", is_final_target: "bool" };

/** Where to go, and how. */
export interface NavigationParameters {
  /** the positions to pass, the last one is the destination */
  readonly target_positions?: readonly string[];
  /** the milliseconds it may take; 0 is no limit */
  readonly time_limit?: number;
  /** what counts more: time or distance */
  readonly routing_policy?: string;
}
const NAVIGATION_PARAMETERS: Types<NavigationParameters> = {
  target_positions: "string[]",
  time_limit: "int",
  routing_policy: "string",
};

/** Goes to a place; `start` is completed at the last position. */
export class Navigation extends RoISCommon<NavigationParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::Navigation";
  protected override readonly parameterTypes = NAVIGATION_PARAMETERS;

  /** A position of the route was reached. */
  readonly reachedTarget = this.event("reached_target", REACHED_TARGET);
}

/** Whom to follow, and how closely. */
export interface FollowParameters {
  /** whom or what to follow */
  readonly target_object_ref?: string;
  /** the millimetres to stay behind */
  readonly distance?: number;
  /** the milliseconds to follow for at most */
  readonly time_limit?: number;
}
const FOLLOW_PARAMETERS: Types<FollowParameters> = {
  target_object_ref: "RoISIdentifier",
  distance: "int",
  time_limit: "int",
};

/** Follows a person or thing until it is stopped. */
export class Follow extends RoISCommon<FollowParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::Follow";
  protected override readonly parameterTypes = FOLLOW_PARAMETERS;
}

/** A motion: along a line or a curve, one of the two. */
export interface MoveParameters {
  /** the millimetres to go and the degrees to turn */
  readonly line?: readonly number[];
  /** the curve's radius in millimetres and its direction in degrees */
  readonly curve?: readonly number[];
  /** the milliseconds it should take */
  readonly time?: number;
}
const MOVE_PARAMETERS: Types<MoveParameters> = { line: "int[]", curve: "int[]", time: "int" };

/** Makes a motion; `start` is completed at its end. */
export class Move extends RoISCommon<MoveParameters> {
  static readonly componentType = "urn:x-rois:def:component:OMG::Move";
  protected override readonly parameterTypes = MOVE_PARAMETERS;
}

/** The stream that was connected. */
export interface ConnectStreamResults {
  /** stands for the stream until it ends */
  readonly stream_id: string;
}
const CONNECT_STREAM_RESULTS: Types<ConnectStreamResults> = { stream_id: "String" };

/** Which stream is meant. */
export interface StreamArguments {
  /** the stream */
  readonly stream_id: string;
}
const STREAM_ARGUMENTS: Types<StreamArguments> = { stream_id: "String" };

/** What a stream does. */
export interface StreamStatusResults {
  /** the stream's status */
  readonly status: StreamStatus;
}
const STREAM_STATUS_RESULTS: Types<StreamStatusResults> = { status: "Stream_Status" };

/** What a stream does now. */
export interface NotifyStreamStatus {
  /** since when */
  readonly timestamp: Date;
  /** the stream's status */
  readonly status: StreamStatus;
  /** the stream */
  readonly stream_id?: string;
}
const NOTIFY_STREAM_STATUS: Types<NotifyStreamStatus> = {
  timestamp: "DateTime",
  status: "Stream_Status",
  stream_id: "string?",
};

/** How streams are to be made, and how they can be. */
export interface StreamingParameters {
  /** the encoding to use */
  readonly encoding_parameters?: string;
  /** the transport to use */
  readonly transport_parameters?: string;
  /** the encodings to choose from; read only */
  readonly available_encodings?: string;
  /** the transports to choose from; read only */
  readonly available_transports?: string;
}
const STREAMING_PARAMETERS: Types<StreamingParameters> = {
  encoding_parameters: "String",
  transport_parameters: "String",
  available_encodings: "String",
  available_transports: "String",
};

/** Streams sound; the media flow beside RoIS. */
export class AudioStreaming extends RoISCommon<
  StreamingParameters,
  "available_encodings" | "available_transports"
> {
  static readonly componentType = "urn:x-rois:def:component:OMG::AudioStreaming";
  protected override readonly parameterTypes = STREAMING_PARAMETERS;

  /** Connect a stream. */
  connectStream(): Promise<ConnectStreamResults> {
    return this.obtain("connect_stream", CONNECT_STREAM_RESULTS);
  }

  /** End a stream. */
  disconnectStream(values: StreamArguments): Promise<void> {
    return this.execute("disconnect_stream", encode(STREAM_ARGUMENTS, values));
  }

  /** Pause a stream. */
  suspendStream(values: StreamArguments): Promise<void> {
    return this.execute("suspend_stream", encode(STREAM_ARGUMENTS, values));
  }

  /** Go on with a stream. */
  resumeStream(values: StreamArguments): Promise<void> {
    return this.execute("resume_stream", encode(STREAM_ARGUMENTS, values));
  }

  /** Ask what a stream does. */
  getStreamStatus(condition?: string): Promise<StreamStatusResults> {
    return this.query("get_stream_status", STREAM_STATUS_RESULTS, condition);
  }

  /** A stream does something else now. */
  readonly notifyStreamStatus = this.event("notify_stream_status", NOTIFY_STREAM_STATUS);
}

/** Streams pictures; the media flow beside RoIS. */
export class VideoStreaming extends RoISCommon<
  StreamingParameters,
  "available_encodings" | "available_transports"
> {
  static readonly componentType = "urn:x-rois:def:component:OMG::VideoStreaming";
  protected override readonly parameterTypes = STREAMING_PARAMETERS;

  /** Connect a stream. */
  connectStream(): Promise<ConnectStreamResults> {
    return this.obtain("connect_stream", CONNECT_STREAM_RESULTS);
  }

  /** End a stream. */
  disconnectStream(values: StreamArguments): Promise<void> {
    return this.execute("disconnect_stream", encode(STREAM_ARGUMENTS, values));
  }

  /** Pause a stream. */
  suspendStream(values: StreamArguments): Promise<void> {
    return this.execute("suspend_stream", encode(STREAM_ARGUMENTS, values));
  }

  /** Go on with a stream. */
  resumeStream(values: StreamArguments): Promise<void> {
    return this.execute("resume_stream", encode(STREAM_ARGUMENTS, values));
  }

  /** Ask what a stream does. */
  getStreamStatus(condition?: string): Promise<StreamStatusResults> {
    return this.query("get_stream_status", STREAM_STATUS_RESULTS, condition);
  }

  /** A stream does something else now. */
  readonly notifyStreamStatus = this.event("notify_stream_status", NOTIFY_STREAM_STATUS);
}
