// The component types of the catalog, by their names on the wire. Written by `make generate`; edits are lost.
namespace OpenRoIS.Components
{
    /// <summary>Messages shared by the basic components.</summary>
    public static class RoISCommon
    {
        public const string Urn = "urn:x-rois:def:Component:OMG::RoISCommon";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }
    }

    /// <summary>
    /// Where the robot is and whether its engine works; mandatory where the engine is a physical unit.
    /// </summary>
    public static class SystemInformation
    {
        public const string Urn = "urn:x-rois:def:component:OMG::SystemInformation";

        public static class Queries
        {
            /// <summary>Ask where the robot and its parts are.</summary>
            public const string RobotPosition = "robot_position";
            /// <summary>Ask whether the engine works.</summary>
            public const string EngineStatus = "engine_status";
        }
    }

    /// <summary>Tells how many persons there are.</summary>
    public static class PersonDetection
    {
        public const string Urn = "urn:x-rois:def:component:OMG::PersonDetection";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>The number of persons has changed.</summary>
            public const string PersonDetected = "person_detected";
        }
    }

    /// <summary>Tells where persons are.</summary>
    public static class PersonLocalization
    {
        public const string Urn = "urn:x-rois:def:component:OMG::PersonLocalization";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>Persons have moved.</summary>
            public const string PersonLocalized = "person_localized";
        }

        public static class Parameters
        {
            /// <summary>tell of movements of more than this many millimetres</summary>
            public const string DetectionThreshold = "detection_threshold";
            /// <summary>tell at most once in this many milliseconds</summary>
            public const string MinimumInterval = "minimum_interval";
        }
    }

    /// <summary>Tells who is there.</summary>
    public static class PersonIdentification
    {
        public const string Urn = "urn:x-rois:def:component:OMG::PersonIdentification";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>Persons were recognised.</summary>
            public const string PersonIdentified = "person_identified";
        }
    }

    /// <summary>Tells how many faces there are.</summary>
    public static class FaceDetection
    {
        public const string Urn = "urn:x-rois:def:component:OMG::FaceDetection";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>The number of faces has changed.</summary>
            public const string FaceDetected = "face_detected";
        }
    }

    /// <summary>Tells where faces are.</summary>
    public static class FaceLocalization
    {
        public const string Urn = "urn:x-rois:def:component:OMG::FaceLocalization";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>Faces have moved.</summary>
            public const string FaceLocalized = "face_localized";
        }

        public static class Parameters
        {
            /// <summary>tell of movements of more than this many millimetres</summary>
            public const string DetectionThreshold = "detection_threshold";
            /// <summary>tell at most once in this many milliseconds</summary>
            public const string MinimumInterval = "minimum_interval";
        }
    }

    /// <summary>Tells how many sound sources there are.</summary>
    public static class SoundDetection
    {
        public const string Urn = "urn:x-rois:def:component:OMG::SoundDetection";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>The number of sound sources has changed.</summary>
            public const string SoundDetected = "sound_detected";
        }
    }

    /// <summary>Tells where sounds come from.</summary>
    public static class SoundLocalization
    {
        public const string Urn = "urn:x-rois:def:component:OMG::SoundLocalization";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>Sound sources have moved.</summary>
            public const string SoundLocalized = "sound_localized";
        }

        public static class Parameters
        {
            /// <summary>tell of movements of more than this many millimetres</summary>
            public const string DetectionThreshold = "detection_threshold";
            /// <summary>tell at most once in this many milliseconds</summary>
            public const string MinimumInterval = "minimum_interval";
        }
    }

    /// <summary>Writes down what is said.</summary>
    public static class SpeechRecognition
    {
        public const string Urn = "urn:x-rois:def:component:OMG::SpeechRecognition";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
            /// <summary>Ask which languages it can be set to recognise.</summary>
            public const string RecognizableLanguages = "recognizable_languages";
        }

        public static class Events
        {
            /// <summary>A person began to speak.</summary>
            public const string SpeechInputStarted = "speech_input_started";
            /// <summary>A person stopped speaking.</summary>
            public const string SpeechInputFinished = "speech_input_finished";
            /// <summary>Something was said.</summary>
            public const string SpeechRecognized = "speech_recognized";
        }

        public static class Parameters
        {
            /// <summary>ISO 639-1 codes</summary>
            public const string Languages = "languages";
            /// <summary>the grammar to use</summary>
            public const string Grammar = "grammar";
            /// <summary>the grammar's rule to begin with</summary>
            public const string Rule = "rule";
        }
    }

    /// <summary>Tells which gestures are made.</summary>
    public static class GestureRecognition
    {
        public const string Urn = "urn:x-rois:def:component:OMG::GestureRecognition";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>A gesture was made.</summary>
            public const string GestureRecognized = "gesture_recognized";
        }

        public static class Parameters
        {
            /// <summary>the gestures it knows; read only</summary>
            public const string RecognizableGestures = "recognizable_gestures";
        }
    }

    /// <summary>Speaks a text; <c>start</c> is completed when it has been spoken.</summary>
    public static class SpeechSynthesis
    {
        public const string Urn = "urn:x-rois:def:component:OMG::SpeechSynthesis";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
            /// <summary>Ask which languages it speaks.</summary>
            public const string SynthesizableLanguages = "synthesizable_languages";
            /// <summary>Ask which voices it has.</summary>
            public const string AvailableVoices = "available_voices";
        }

        public static class Parameters
        {
            /// <summary>the text to speak</summary>
            public const string SpeechText = "speech_text";
            /// <summary>the SSML to speak; unknown tags are skipped</summary>
            public const string SsmlText = "ssml_text";
            /// <summary>how loud, 0 to 100</summary>
            public const string Volume = "volume";
            /// <summary>ISO 639-1 code</summary>
            public const string Language = "language";
            /// <summary>the voice's name, as in available_voices</summary>
            public const string Character = "character";
        }
    }

    /// <summary>Plays a reaction, such as a nod.</summary>
    public static class Reaction
    {
        public const string Urn = "urn:x-rois:def:component:OMG::Reaction";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
            /// <summary>Ask which reactions it can play.</summary>
            public const string AvailableReactions = "available_reactions";
        }

        public static class Parameters
        {
            /// <summary>the reaction to play</summary>
            public const string ReactionRef = "reaction_ref";
        }
    }

    /// <summary>Goes to a place; <c>start</c> is completed at the last position.</summary>
    public static class Navigation
    {
        public const string Urn = "urn:x-rois:def:component:OMG::Navigation";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Events
        {
            /// <summary>A position of the route was reached.</summary>
            public const string ReachedTarget = "reached_target";
        }

        public static class Parameters
        {
            /// <summary>the positions to pass, the last one is the destination</summary>
            public const string TargetPositions = "target_positions";
            /// <summary>the milliseconds it may take; 0 is no limit</summary>
            public const string TimeLimit = "time_limit";
            /// <summary>what counts more: time or distance</summary>
            public const string RoutingPolicy = "routing_policy";
        }
    }

    /// <summary>Follows a person or thing until it is stopped.</summary>
    public static class Follow
    {
        public const string Urn = "urn:x-rois:def:component:OMG::Follow";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Parameters
        {
            /// <summary>whom or what to follow</summary>
            public const string TargetObjectRef = "target_object_ref";
            /// <summary>the millimetres to stay behind</summary>
            public const string Distance = "distance";
            /// <summary>the milliseconds to follow for at most</summary>
            public const string TimeLimit = "time_limit";
        }
    }

    /// <summary>Makes a motion; <c>start</c> is completed at its end.</summary>
    public static class Move
    {
        public const string Urn = "urn:x-rois:def:component:OMG::Move";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
        }

        public static class Parameters
        {
            /// <summary>the millimetres to go and the degrees to turn</summary>
            public const string Line = "line";
            /// <summary>the curve's radius in millimetres and its direction in degrees</summary>
            public const string Curve = "curve";
            /// <summary>the milliseconds it should take</summary>
            public const string Time = "time";
        }
    }

    /// <summary>Streams sound; the media flow beside RoIS.</summary>
    public static class AudioStreaming
    {
        public const string Urn = "urn:x-rois:def:component:OMG::AudioStreaming";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
            /// <summary>Connect a stream.</summary>
            public const string ConnectStream = "connect_stream";
            /// <summary>End a stream.</summary>
            public const string DisconnectStream = "disconnect_stream";
            /// <summary>Pause a stream.</summary>
            public const string SuspendStream = "suspend_stream";
            /// <summary>Go on with a stream.</summary>
            public const string ResumeStream = "resume_stream";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
            /// <summary>Ask what a stream does.</summary>
            public const string GetStreamStatus = "get_stream_status";
        }

        public static class Events
        {
            /// <summary>A stream does something else now.</summary>
            public const string NotifyStreamStatus = "notify_stream_status";
        }

        public static class Parameters
        {
            /// <summary>the encoding to use</summary>
            public const string EncodingParameters = "encoding_parameters";
            /// <summary>the transport to use</summary>
            public const string TransportParameters = "transport_parameters";
            /// <summary>the encodings to choose from; read only</summary>
            public const string AvailableEncodings = "available_encodings";
            /// <summary>the transports to choose from; read only</summary>
            public const string AvailableTransports = "available_transports";
        }
    }

    /// <summary>Streams pictures; the media flow beside RoIS.</summary>
    public static class VideoStreaming
    {
        public const string Urn = "urn:x-rois:def:component:OMG::VideoStreaming";

        public static class Commands
        {
            /// <summary>Begin what the component is for.</summary>
            public const string Start = "start";
            /// <summary>End it.</summary>
            public const string Stop = "stop";
            /// <summary>Pause it.</summary>
            public const string Suspend = "suspend";
            /// <summary>Go on with it.</summary>
            public const string Resume = "resume";
            /// <summary>Connect a stream.</summary>
            public const string ConnectStream = "connect_stream";
            /// <summary>End a stream.</summary>
            public const string DisconnectStream = "disconnect_stream";
            /// <summary>Pause a stream.</summary>
            public const string SuspendStream = "suspend_stream";
            /// <summary>Go on with a stream.</summary>
            public const string ResumeStream = "resume_stream";
        }

        public static class Queries
        {
            /// <summary>Ask what the component is able to do now.</summary>
            public const string ComponentStatus = "component_status";
            /// <summary>Ask what a stream does.</summary>
            public const string GetStreamStatus = "get_stream_status";
        }

        public static class Events
        {
            /// <summary>A stream does something else now.</summary>
            public const string NotifyStreamStatus = "notify_stream_status";
        }

        public static class Parameters
        {
            /// <summary>the encoding to use</summary>
            public const string EncodingParameters = "encoding_parameters";
            /// <summary>the transport to use</summary>
            public const string TransportParameters = "transport_parameters";
            /// <summary>the encodings to choose from; read only</summary>
            public const string AvailableEncodings = "available_encodings";
            /// <summary>the transports to choose from; read only</summary>
            public const string AvailableTransports = "available_transports";
        }
    }
}
