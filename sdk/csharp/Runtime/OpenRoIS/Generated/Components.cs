// The component types of the catalog, as an application sees them. Written by `make generate`; edits are lost.
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS.Components
{
    /// <summary>Messages shared by the basic components.</summary>
    public class RoISCommon : ComponentProxy
    {
        public const string Urn = "urn:x-rois:def:Component:OMG::RoISCommon";

        public static readonly ComponentType<RoISCommon> Type =
            new ComponentType<RoISCommon>(Urn, (client, componentRef) => new RoISCommon(client, componentRef));

        public RoISCommon(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Begin what the component is for.</summary>
        public Task StartAsync(CancellationToken token = default(CancellationToken))
        {
            return StartStep().RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step StartStep()
        {
            return Command("start");
        }

        /// <summary>End it.</summary>
        public Task StopAsync(CancellationToken token = default(CancellationToken))
        {
            return StopStep().RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step StopStep()
        {
            return Command("stop");
        }

        /// <summary>Pause it.</summary>
        public Task SuspendAsync(CancellationToken token = default(CancellationToken))
        {
            return SuspendStep().RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SuspendStep()
        {
            return Command("suspend");
        }

        /// <summary>Go on with it.</summary>
        public Task ResumeAsync(CancellationToken token = default(CancellationToken))
        {
            return ResumeStep().RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step ResumeStep()
        {
            return Command("resume");
        }

        /// <summary>Ask what the component is able to do now. Returns the component's status.</summary>
        public Task<ComponentStatus> ComponentStatusAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("component_status", told => told.Enumerator<ComponentStatus>("status"), token);
        }

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
    public sealed class SystemInformation : ComponentProxy
    {
        public const string Urn = "urn:x-rois:def:component:OMG::SystemInformation";

        public static readonly ComponentType<SystemInformation> Type =
            new ComponentType<SystemInformation>(Urn, (client, componentRef) => new SystemInformation(client, componentRef));

        public SystemInformation(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Ask where the robot and its parts are.</summary>
        public Task<RobotPositionResult> RobotPositionAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("robot_position", Components.RobotPositionResult.Read, token);
        }

        /// <summary>Ask whether the engine works.</summary>
        public Task<EngineStatusResult> EngineStatusAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("engine_status", Components.EngineStatusResult.Read, token);
        }

        public static class Queries
        {
            /// <summary>Ask where the robot and its parts are.</summary>
            public const string RobotPosition = "robot_position";
            /// <summary>Ask whether the engine works.</summary>
            public const string EngineStatus = "engine_status";
        }
    }

    /// <summary>Tells how many persons there are.</summary>
    public sealed class PersonDetection : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::PersonDetection";

        public static new readonly ComponentType<PersonDetection> Type =
            new ComponentType<PersonDetection>(Urn, (client, componentRef) => new PersonDetection(client, componentRef));

        public PersonDetection(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>The number of persons has changed.</summary>
        public ComponentEvent<PersonDetected> PersonDetected
        {
            get { return Event("person_detected", Components.PersonDetected.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class PersonLocalization : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::PersonLocalization";

        public static new readonly ComponentType<PersonLocalization> Type =
            new ComponentType<PersonLocalization>(Urn, (client, componentRef) => new PersonLocalization(client, componentRef));

        public PersonLocalization(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="detectionThreshold">tell of movements of more than this many millimetres</param>
        /// <param name="minimumInterval">tell at most once in this many milliseconds</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            long? detectionThreshold = null,
            long? minimumInterval = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(detectionThreshold, minimumInterval).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(long? detectionThreshold = null, long? minimumInterval = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("detection_threshold", "int", detectionThreshold)
                    .Add("minimum_interval", "int", minimumInterval));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<LocalizationParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.LocalizationParameters.Read, token);
        }

        /// <summary>Persons have moved.</summary>
        public ComponentEvent<PersonLocalized> PersonLocalized
        {
            get { return Event("person_localized", Components.PersonLocalized.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class PersonIdentification : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::PersonIdentification";

        public static new readonly ComponentType<PersonIdentification> Type =
            new ComponentType<PersonIdentification>(Urn, (client, componentRef) => new PersonIdentification(client, componentRef));

        public PersonIdentification(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Persons were recognised.</summary>
        public ComponentEvent<PersonIdentified> PersonIdentified
        {
            get { return Event("person_identified", Components.PersonIdentified.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class FaceDetection : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::FaceDetection";

        public static new readonly ComponentType<FaceDetection> Type =
            new ComponentType<FaceDetection>(Urn, (client, componentRef) => new FaceDetection(client, componentRef));

        public FaceDetection(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>The number of faces has changed.</summary>
        public ComponentEvent<FaceDetected> FaceDetected
        {
            get { return Event("face_detected", Components.FaceDetected.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class FaceLocalization : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::FaceLocalization";

        public static new readonly ComponentType<FaceLocalization> Type =
            new ComponentType<FaceLocalization>(Urn, (client, componentRef) => new FaceLocalization(client, componentRef));

        public FaceLocalization(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="detectionThreshold">tell of movements of more than this many millimetres</param>
        /// <param name="minimumInterval">tell at most once in this many milliseconds</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            long? detectionThreshold = null,
            long? minimumInterval = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(detectionThreshold, minimumInterval).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(long? detectionThreshold = null, long? minimumInterval = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("detection_threshold", "int", detectionThreshold)
                    .Add("minimum_interval", "int", minimumInterval));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<LocalizationParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.LocalizationParameters.Read, token);
        }

        /// <summary>Faces have moved.</summary>
        public ComponentEvent<FaceLocalized> FaceLocalized
        {
            get { return Event("face_localized", Components.FaceLocalized.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class SoundDetection : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::SoundDetection";

        public static new readonly ComponentType<SoundDetection> Type =
            new ComponentType<SoundDetection>(Urn, (client, componentRef) => new SoundDetection(client, componentRef));

        public SoundDetection(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>The number of sound sources has changed.</summary>
        public ComponentEvent<SoundDetected> SoundDetected
        {
            get { return Event("sound_detected", Components.SoundDetected.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class SoundLocalization : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::SoundLocalization";

        public static new readonly ComponentType<SoundLocalization> Type =
            new ComponentType<SoundLocalization>(Urn, (client, componentRef) => new SoundLocalization(client, componentRef));

        public SoundLocalization(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="detectionThreshold">tell of movements of more than this many millimetres</param>
        /// <param name="minimumInterval">tell at most once in this many milliseconds</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            long? detectionThreshold = null,
            long? minimumInterval = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(detectionThreshold, minimumInterval).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(long? detectionThreshold = null, long? minimumInterval = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("detection_threshold", "int", detectionThreshold)
                    .Add("minimum_interval", "int", minimumInterval));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<LocalizationParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.LocalizationParameters.Read, token);
        }

        /// <summary>Sound sources have moved.</summary>
        public ComponentEvent<SoundLocalized> SoundLocalized
        {
            get { return Event("sound_localized", Components.SoundLocalized.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class SpeechRecognition : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::SpeechRecognition";

        public static new readonly ComponentType<SpeechRecognition> Type =
            new ComponentType<SpeechRecognition>(Urn, (client, componentRef) => new SpeechRecognition(client, componentRef));

        public SpeechRecognition(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="languages">ISO 639-1 codes</param>
        /// <param name="grammar">the grammar to use</param>
        /// <param name="rule">the grammar's rule to begin with</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            IEnumerable<string> languages = null,
            string grammar = null,
            string rule = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(languages, grammar, rule).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(IEnumerable<string> languages = null, string grammar = null, string rule = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("languages", "string[]", languages)
                    .Add("grammar", "string", grammar)
                    .Add("rule", "string", rule));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<SpeechRecognitionParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.SpeechRecognitionParameters.Read, token);
        }

        /// <summary>Ask which languages it can be set to recognise. Returns ISO 639-1 codes.</summary>
        public Task<IReadOnlyList<string>> RecognizableLanguagesAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("recognizable_languages", told => told.List<string>("languages", "string[]"), token);
        }

        /// <summary>A person began to speak.</summary>
        public ComponentEvent<SpeechInputStarted> SpeechInputStarted
        {
            get { return Event("speech_input_started", Components.SpeechInputStarted.Read); }
        }

        /// <summary>A person stopped speaking.</summary>
        public ComponentEvent<SpeechInputFinished> SpeechInputFinished
        {
            get { return Event("speech_input_finished", Components.SpeechInputFinished.Read); }
        }

        /// <summary>Something was said.</summary>
        public ComponentEvent<SpeechRecognized> SpeechRecognized
        {
            get { return Event("speech_recognized", Components.SpeechRecognized.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class GestureRecognition : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::GestureRecognition";

        public static new readonly ComponentType<GestureRecognition> Type =
            new ComponentType<GestureRecognition>(Urn, (client, componentRef) => new GestureRecognition(client, componentRef));

        public GestureRecognition(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<GestureRecognitionParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.GestureRecognitionParameters.Read, token);
        }

        /// <summary>A gesture was made.</summary>
        public ComponentEvent<GestureRecognized> GestureRecognized
        {
            get { return Event("gesture_recognized", Components.GestureRecognized.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class SpeechSynthesis : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::SpeechSynthesis";

        public static new readonly ComponentType<SpeechSynthesis> Type =
            new ComponentType<SpeechSynthesis>(Urn, (client, componentRef) => new SpeechSynthesis(client, componentRef));

        public SpeechSynthesis(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="speechText">the text to speak</param>
        /// <param name="ssmlText">the SSML to speak; unknown tags are skipped</param>
        /// <param name="volume">how loud, 0 to 100</param>
        /// <param name="language">ISO 639-1 code</param>
        /// <param name="character">the voice's name, as in available_voices</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            string speechText = null,
            string ssmlText = null,
            long? volume = null,
            string language = null,
            string character = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(speechText, ssmlText, volume, language, character).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(
            string speechText = null,
            string ssmlText = null,
            long? volume = null,
            string language = null,
            string character = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("speech_text", "string", speechText)
                    .Add("ssml_text", "string", ssmlText)
                    .Add("volume", "int", volume)
                    .Add("language", "string", language)
                    .Add("character", "string", character));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<SpeechSynthesisParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.SpeechSynthesisParameters.Read, token);
        }

        /// <summary>Ask which languages it speaks. Returns ISO 639-1 codes.</summary>
        public Task<IReadOnlyList<string>> SynthesizableLanguagesAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("synthesizable_languages", told => told.List<string>("languages", "string[]"), token);
        }

        /// <summary>Ask which voices it has. Returns names of voices.</summary>
        public Task<IReadOnlyList<string>> AvailableVoicesAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("available_voices", told => told.List<string>("characters", "string[]"), token);
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class Reaction : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::Reaction";

        public static new readonly ComponentType<Reaction> Type =
            new ComponentType<Reaction>(Urn, (client, componentRef) => new Reaction(client, componentRef));

        public Reaction(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="reactionRef">the reaction to play</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            string reactionRef = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(reactionRef).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(string reactionRef = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("reaction_ref", "RoISIdentifier", reactionRef));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<ReactionParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.ReactionParameters.Read, token);
        }

        /// <summary>Ask which reactions it can play. Returns refs of reactions.</summary>
        public Task<IReadOnlyList<string>> AvailableReactionsAsync(
            CancellationToken token = default(CancellationToken))
        {
            return QueryAsync("available_reactions", told => told.List<string>("available_reactions", "RoISIdentifier[]"), token);
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class Navigation : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::Navigation";

        public static new readonly ComponentType<Navigation> Type =
            new ComponentType<Navigation>(Urn, (client, componentRef) => new Navigation(client, componentRef));

        public Navigation(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="targetPositions">the positions to pass, the last one is the destination</param>
        /// <param name="timeLimit">the milliseconds it may take; 0 is no limit</param>
        /// <param name="routingPolicy">what counts more: time or distance</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            IEnumerable<string> targetPositions = null,
            long? timeLimit = null,
            string routingPolicy = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(targetPositions, timeLimit, routingPolicy).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(
            IEnumerable<string> targetPositions = null,
            long? timeLimit = null,
            string routingPolicy = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("target_positions", "string[]", targetPositions)
                    .Add("time_limit", "int", timeLimit)
                    .Add("routing_policy", "string", routingPolicy));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<NavigationParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.NavigationParameters.Read, token);
        }

        /// <summary>A position of the route was reached.</summary>
        public ComponentEvent<ReachedTarget> ReachedTarget
        {
            get { return Event("reached_target", Components.ReachedTarget.Read); }
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class Follow : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::Follow";

        public static new readonly ComponentType<Follow> Type =
            new ComponentType<Follow>(Urn, (client, componentRef) => new Follow(client, componentRef));

        public Follow(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="targetObjectRef">whom or what to follow</param>
        /// <param name="distance">the millimetres to stay behind</param>
        /// <param name="timeLimit">the milliseconds to follow for at most</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            string targetObjectRef = null,
            long? distance = null,
            long? timeLimit = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(targetObjectRef, distance, timeLimit).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(string targetObjectRef = null, long? distance = null, long? timeLimit = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("target_object_ref", "RoISIdentifier", targetObjectRef)
                    .Add("distance", "int", distance)
                    .Add("time_limit", "int", timeLimit));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<FollowParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.FollowParameters.Read, token);
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class Move : RoISCommon
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::Move";

        public static new readonly ComponentType<Move> Type =
            new ComponentType<Move>(Urn, (client, componentRef) => new Move(client, componentRef));

        public Move(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="line">the millimetres to go and the degrees to turn</param>
        /// <param name="curve">the curve's radius in millimetres and its direction in degrees</param>
        /// <param name="time">the milliseconds it should take</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            IEnumerable<long> line = null,
            IEnumerable<long> curve = null,
            long? time = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(line, curve, time).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(
            IEnumerable<long> line = null,
            IEnumerable<long> curve = null,
            long? time = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("line", "int[]", line)
                    .Add("curve", "int[]", curve)
                    .Add("time", "int", time));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<MoveParameters> GetParametersAsync(CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.MoveParameters.Read, token);
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class AudioStreaming : Streaming
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::AudioStreaming";

        public static new readonly ComponentType<AudioStreaming> Type =
            new ComponentType<AudioStreaming>(Urn, (client, componentRef) => new AudioStreaming(client, componentRef));

        public AudioStreaming(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="encodingParameters">the encoding to use</param>
        /// <param name="transportParameters">the transport to use</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            string encodingParameters = null,
            string transportParameters = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(encodingParameters, transportParameters).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(string encodingParameters = null, string transportParameters = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("encoding_parameters", "String", encodingParameters)
                    .Add("transport_parameters", "String", transportParameters));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<StreamingParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.StreamingParameters.Read, token);
        }

        public new static class Commands
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

        public new static class Queries
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
    public sealed class VideoStreaming : Streaming
    {
        public new const string Urn = "urn:x-rois:def:component:OMG::VideoStreaming";

        public static new readonly ComponentType<VideoStreaming> Type =
            new ComponentType<VideoStreaming>(Urn, (client, componentRef) => new VideoStreaming(client, componentRef));

        public VideoStreaming(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        /// <summary>Changes parameters, all at once; null and those that are not named stay as they are.</summary>
        /// <param name="encodingParameters">the encoding to use</param>
        /// <param name="transportParameters">the transport to use</param>
        /// <param name="token">ends the wait</param>
        public Task SetAsync(
            string encodingParameters = null,
            string transportParameters = null,
            CancellationToken token = default(CancellationToken))
        {
            return SetStep(encodingParameters, transportParameters).RunAsync(token);
        }

        /// <summary>The same as a step of a sequence.</summary>
        public Step SetStep(string encodingParameters = null, string transportParameters = null)
        {
            return Command("set_parameter", new Arguments()
                    .Add("encoding_parameters", "String", encodingParameters)
                    .Add("transport_parameters", "String", transportParameters));
        }

        /// <summary>Returns the parameters that have a value; the others are null.</summary>
        public Task<StreamingParameters> GetParametersAsync(
            CancellationToken token = default(CancellationToken))
        {
            return ParametersAsync(Components.StreamingParameters.Read, token);
        }

        public new static class Commands
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

        public new static class Queries
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
