// An application that speaks through an avatar, visits it, and listens to who else does.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;

/// <summary>Speaks a text, word by word, and visits; sound of its own it cannot send without a WebRTC library.</summary>
public static class Visiting
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        await Speak(client);
        await Visit(client);
        await client.CloseAsync();
    }

    private static async Task Speak(Client client)
    {
        SpeechSynthesis speech = await client.FindAsync(SpeechSynthesis.Type);
        var progress = new Progress(client, "avatar/speech_progress");
        await speech.BindAsync();
        using (EventReader<string> words = await progress.WordSpoken.ReadAsync())
        using (EventReader<object[]> ends = await progress.SpeechEnded.ReadAsync())
        {
            await speech.SetAsync(speechText: "Hello world");
            await speech.StartAsync();
            var said = new List<string>();
            while (said.Count < 2 && await words.MoveNextAsync())
            {
                said.Add(words.Current);
            }
            Program.Say("words", said);
            await ends.MoveNextAsync();
            Program.Say("end", ends.Current);
        }
        await speech.ReleaseAsync();
        // The right to speak by sound is had in C#; the channel is one of a WebRTC library.
        var sound = new Sound(client, "avatar/speech_stream");
        await sound.BindAsync();
        Program.Say("speeches", await sound.SpeechesAsync());
        await sound.ReleaseAsync();
    }

    private static async Task Visit(Client client)
    {
        var visitors = new Visitors(client, "avatar/visitors");
        using (EventReader<string[]> changes = await visitors.VisitorChanged.ReadAsync())
        {
            AudioStreaming ears = await client.FindAsync(AudioStreaming.Type);
            string streamId = await ears.ConnectStreamAsync(
                transport: new { direction = "sendonly", consent = new[] { "live" } });
            await changes.MoveNextAsync();
            string name = changes.Current[0];
            Program.Say("comes", changes.Current.Skip(1));
            Program.Say("is named", await ears.SetConsentAsync(streamId, new[] { Purpose.Live, Purpose.Agent }) == name);
            await changes.MoveNextAsync();
            Program.Say("consents", changes.Current.Skip(1));
            Program.Say("present", (await visitors.PresentAsync()).SequenceEqual(new[] { name }));
            await ears.SetConsentAsync(streamId, new Purpose[0]);
            await changes.MoveNextAsync();
            Program.Say("withdraws", changes.Current.Skip(1));
            await ears.DisconnectStreamAsync(streamId);
            await changes.MoveNextAsync();
            Program.Say("leaves", changes.Current.Skip(1));
            Program.Say("is unknown", await Program.Thrown(() => ears.SetConsentAsync(streamId, new[] { Purpose.Live })));
        }
    }

    /// <summary>The avatar's own component of that name.</summary>
    private sealed class Progress : ComponentProxy
    {
        internal Progress(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        internal ComponentEvent<string> WordSpoken
        {
            get { return Event("word_spoken", told => told.Value<string>("word", "string")); }
        }

        internal ComponentEvent<object[]> SpeechEnded
        {
            get
            {
                return Event("speech_ended", told => new object[]
                {
                    told.Value<string>("status", "string"), told.Value<long>("heard_ms", "int") > 0
                });
            }
        }
    }

    /// <summary>The avatar's own component SpeechStream.</summary>
    private sealed class Sound : ComponentProxy
    {
        internal Sound(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        internal Task<long> SpeechesAsync()
        {
            return QueryAsync("streaming", told => told.Value<long>("speeches", "int"), CancellationToken.None);
        }
    }

    /// <summary>The avatar's own component Visitors.</summary>
    private sealed class Visitors : ComponentProxy
    {
        internal Visitors(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        internal ComponentEvent<string[]> VisitorChanged
        {
            get
            {
                return Event("visitor_changed", told => new[]
                {
                    told.Value<string>("visitor_ref", "string"),
                    told.Value<string>("devices", "string"),
                    told.Value<string>("consent", "string")
                });
            }
        }

        internal Task<IReadOnlyList<string>> PresentAsync()
        {
            return QueryAsync(
                "visitors", told => told.List<string>("visitor_ref", "string[]"), CancellationToken.None);
        }
    }
}
