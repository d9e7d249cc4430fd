// What the messages of the catalog's components carry. Written by `make generate`; edits are lost.
using System;
using System.Collections.Generic;

namespace OpenRoIS.Components
{
    /// <summary>Where the robot, its sensors and its actuators are; the lists run in parallel.</summary>
    public sealed class RobotPositionResult
    {
        /// <summary>a position x,y,th for each ref</summary>
        public IReadOnlyList<string> PositionData { get; private set; }

        /// <summary>whose positions they are</summary>
        public IReadOnlyList<string> RobotRef { get; private set; }

        /// <summary>when they were measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static RobotPositionResult Read(Payload told)
        {
            return new RobotPositionResult
            {
                PositionData = told.List<string>("position_data", "String[]"),
                RobotRef = told.List<string>("robot_ref", "RoISIdentifier[]"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>Whether the engine works.</summary>
    public sealed class EngineStatusResult
    {
        /// <summary>the engine's status</summary>
        public ComponentStatus Status { get; private set; }

        /// <summary>when it can be used</summary>
        public DateTimeOffset? OperableTime { get; private set; }

        internal static EngineStatusResult Read(Payload told)
        {
            return new EngineStatusResult
            {
                Status = told.Enumerator<ComponentStatus>("status"),
                OperableTime = told.FindMoment("operable_time")
            };
        }
    }

    /// <summary>The number of persons has changed.</summary>
    public sealed class PersonDetected
    {
        /// <summary>how many there are now</summary>
        public long Number { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static PersonDetected Read(Payload told)
        {
            return new PersonDetected
            {
                Number = told.Value<long>("number", "int"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>Where persons are; the lists run in parallel.</summary>
    public sealed class PersonLocalized
    {
        /// <summary>who or what they are, with reference information</summary>
        public IReadOnlyList<string> PersonRef { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        /// <summary>a position x,y,th for each ref</summary>
        public IReadOnlyList<string> PositionData { get; private set; }

        internal static PersonLocalized Read(Payload told)
        {
            return new PersonLocalized
            {
                PersonRef = told.List<string>("person_ref", "RoISIdentifier[]"),
                Timestamp = told.Moment("timestamp"),
                PositionData = told.List<string>("position_data", "String[]")
            };
        }
    }

    /// <summary>When to tell that something has moved.</summary>
    public sealed class LocalizationParameters
    {
        /// <summary>tell of movements of more than this many millimetres</summary>
        public long? DetectionThreshold { get; private set; }

        /// <summary>tell at most once in this many milliseconds</summary>
        public long? MinimumInterval { get; private set; }

        internal static LocalizationParameters Read(Payload told)
        {
            return new LocalizationParameters
            {
                DetectionThreshold = (long?)told.Find("detection_threshold", "int"),
                MinimumInterval = (long?)told.Find("minimum_interval", "int")
            };
        }
    }

    /// <summary>Who is there.</summary>
    public sealed class PersonIdentified
    {
        /// <summary>who or what they are, with reference information</summary>
        public IReadOnlyList<string> PersonRef { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static PersonIdentified Read(Payload told)
        {
            return new PersonIdentified
            {
                PersonRef = told.List<string>("person_ref", "RoISIdentifier[]"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>The number of faces has changed.</summary>
    public sealed class FaceDetected
    {
        /// <summary>how many there are now</summary>
        public long Number { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static FaceDetected Read(Payload told)
        {
            return new FaceDetected
            {
                Number = told.Value<long>("number", "int"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>Where faces are; the lists run in parallel.</summary>
    public sealed class FaceLocalized
    {
        /// <summary>who or what they are, with reference information</summary>
        public IReadOnlyList<string> FaceRef { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        /// <summary>a position x,y,th for each ref</summary>
        public IReadOnlyList<string> PositionData { get; private set; }

        internal static FaceLocalized Read(Payload told)
        {
            return new FaceLocalized
            {
                FaceRef = told.List<string>("face_ref", "RoISIdentifier[]"),
                Timestamp = told.Moment("timestamp"),
                PositionData = told.List<string>("position_data", "String[]")
            };
        }
    }

    /// <summary>The number of sound sources has changed; 0 or 1 where sources cannot be told apart.</summary>
    public sealed class SoundDetected
    {
        /// <summary>how many there are now</summary>
        public long Number { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static SoundDetected Read(Payload told)
        {
            return new SoundDetected
            {
                Number = told.Value<long>("number", "int"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>Where sounds come from; the lists run in parallel.</summary>
    public sealed class SoundLocalized
    {
        /// <summary>who or what they are, with reference information</summary>
        public IReadOnlyList<string> SoundRef { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        /// <summary>a position x,y,th for each ref</summary>
        public IReadOnlyList<string> PositionData { get; private set; }

        internal static SoundLocalized Read(Payload told)
        {
            return new SoundLocalized
            {
                SoundRef = told.List<string>("sound_ref", "RoISIdentifier[]"),
                Timestamp = told.Moment("timestamp"),
                PositionData = told.List<string>("position_data", "String[]")
            };
        }
    }

    /// <summary>A person began to speak.</summary>
    public sealed class SpeechInputStarted
    {
        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static SpeechInputStarted Read(Payload told)
        {
            return new SpeechInputStarted
            {
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>A person stopped speaking.</summary>
    public sealed class SpeechInputFinished
    {
        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static SpeechInputFinished Read(Payload told)
        {
            return new SpeechInputFinished
            {
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>What was said.</summary>
    public sealed class SpeechRecognized
    {
        /// <summary>what may have been said, the likeliest first</summary>
        public IReadOnlyList<string> RecognizedText { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static SpeechRecognized Read(Payload told)
        {
            return new SpeechRecognized
            {
                RecognizedText = told.List<string>("recognized_text", "string[]"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>What speech to expect.</summary>
    public sealed class SpeechRecognitionParameters
    {
        /// <summary>ISO 639-1 codes</summary>
        public IReadOnlyList<string> Languages { get; private set; }

        /// <summary>the grammar to use</summary>
        public string Grammar { get; private set; }

        /// <summary>the grammar's rule to begin with</summary>
        public string Rule { get; private set; }

        internal static SpeechRecognitionParameters Read(Payload told)
        {
            return new SpeechRecognitionParameters
            {
                Languages = told.FindList<string>("languages", "string[]"),
                Grammar = (string)told.Find("grammar", "string"),
                Rule = (string)told.Find("rule", "string")
            };
        }
    }

    /// <summary>A gesture was made.</summary>
    public sealed class GestureRecognized
    {
        /// <summary>who or what they are, with reference information</summary>
        public IReadOnlyList<string> GestureRef { get; private set; }

        /// <summary>when it was measured</summary>
        public DateTimeOffset Timestamp { get; private set; }

        internal static GestureRecognized Read(Payload told)
        {
            return new GestureRecognized
            {
                GestureRef = told.List<string>("gesture_ref", "RoISIdentifier[]"),
                Timestamp = told.Moment("timestamp")
            };
        }
    }

    /// <summary>What gestures can be recognised.</summary>
    public sealed class GestureRecognitionParameters
    {
        /// <summary>the gestures it knows; read only</summary>
        public IReadOnlyList<string> RecognizableGestures { get; private set; }

        internal static GestureRecognitionParameters Read(Payload told)
        {
            return new GestureRecognitionParameters
            {
                RecognizableGestures = told.FindList<string>("recognizable_gestures", "RoISIdentifier[]")
            };
        }
    }

    /// <summary>What to say and how: plain text or SSML, one of the two.</summary>
    public sealed class SpeechSynthesisParameters
    {
        /// <summary>the text to speak</summary>
        public string SpeechText { get; private set; }

        /// <summary>the SSML to speak; unknown tags are skipped</summary>
        public string SsmlText { get; private set; }

        /// <summary>how loud, 0 to 100</summary>
        public long? Volume { get; private set; }

        /// <summary>ISO 639-1 code</summary>
        public string Language { get; private set; }

        /// <summary>the voice's name, as in available_voices</summary>
        public string Character { get; private set; }

        internal static SpeechSynthesisParameters Read(Payload told)
        {
            return new SpeechSynthesisParameters
            {
                SpeechText = (string)told.Find("speech_text", "string"),
                SsmlText = (string)told.Find("ssml_text", "string"),
                Volume = (long?)told.Find("volume", "int"),
                Language = (string)told.Find("language", "string"),
                Character = (string)told.Find("character", "string")
            };
        }
    }

    /// <summary>Which reaction to play.</summary>
    public sealed class ReactionParameters
    {
        /// <summary>the reaction to play</summary>
        public string ReactionRef { get; private set; }

        internal static ReactionParameters Read(Payload told)
        {
            return new ReactionParameters
            {
                ReactionRef = (string)told.Find("reaction_ref", "RoISIdentifier")
            };
        }
    }

    /// <summary>A position of the route was reached.</summary>
    public sealed class ReachedTarget
    {
        /// <summary>the position</summary>
        public string Target { get; private set; }

        /// <summary>whether it is the last one</summary>
        public bool IsFinalTarget { get; private set; }

        internal static ReachedTarget Read(Payload told)
        {
            return new ReachedTarget
            {
                Target = told.Value<string>("target", "string"),
                IsFinalTarget = told.Value<bool>("is_final_target", "bool")
            };
        }
    }

    /// <summary>Where to go, and how.</summary>
    public sealed class NavigationParameters
    {
        /// <summary>the positions to pass, the last one is the destination</summary>
        public IReadOnlyList<string> TargetPositions { get; private set; }

        /// <summary>the milliseconds it may take; 0 is no limit</summary>
        public long? TimeLimit { get; private set; }

        /// <summary>what counts more: time or distance</summary>
        public string RoutingPolicy { get; private set; }

        internal static NavigationParameters Read(Payload told)
        {
            return new NavigationParameters
            {
                TargetPositions = told.FindList<string>("target_positions", "string[]"),
                TimeLimit = (long?)told.Find("time_limit", "int"),
                RoutingPolicy = (string)told.Find("routing_policy", "string")
            };
        }
    }

    /// <summary>Whom to follow, and how closely.</summary>
    public sealed class FollowParameters
    {
        /// <summary>whom or what to follow</summary>
        public string TargetObjectRef { get; private set; }

        /// <summary>the millimetres to stay behind</summary>
        public long? Distance { get; private set; }

        /// <summary>the milliseconds to follow for at most</summary>
        public long? TimeLimit { get; private set; }

        internal static FollowParameters Read(Payload told)
        {
            return new FollowParameters
            {
                TargetObjectRef = (string)told.Find("target_object_ref", "RoISIdentifier"),
                Distance = (long?)told.Find("distance", "int"),
                TimeLimit = (long?)told.Find("time_limit", "int")
            };
        }
    }

    /// <summary>A motion: along a line or a curve, one of the two.</summary>
    public sealed class MoveParameters
    {
        /// <summary>the millimetres to go and the degrees to turn</summary>
        public IReadOnlyList<long> Line { get; private set; }

        /// <summary>the curve's radius in millimetres and its direction in degrees</summary>
        public IReadOnlyList<long> Curve { get; private set; }

        /// <summary>the milliseconds it should take</summary>
        public long? Time { get; private set; }

        internal static MoveParameters Read(Payload told)
        {
            return new MoveParameters
            {
                Line = told.FindList<long>("line", "int[]"),
                Curve = told.FindList<long>("curve", "int[]"),
                Time = (long?)told.Find("time", "int")
            };
        }
    }

    /// <summary>How streams are to be made, and how they can be.</summary>
    public sealed class StreamingParameters
    {
        /// <summary>the encoding to use</summary>
        public string EncodingParameters { get; private set; }

        /// <summary>the transport to use</summary>
        public string TransportParameters { get; private set; }

        /// <summary>the encodings to choose from; read only</summary>
        public string AvailableEncodings { get; private set; }

        /// <summary>the transports to choose from; read only</summary>
        public string AvailableTransports { get; private set; }

        internal static StreamingParameters Read(Payload told)
        {
            return new StreamingParameters
            {
                EncodingParameters = (string)told.Find("encoding_parameters", "String"),
                TransportParameters = (string)told.Find("transport_parameters", "String"),
                AvailableEncodings = (string)told.Find("available_encodings", "String"),
                AvailableTransports = (string)told.Find("available_transports", "String")
            };
        }
    }
}
