// Applications with streams.
using System;
using System.Collections.Generic;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;
using OpenRoIS.Media;

/// <summary>Connects, suspends, resumes and ends a stream.</summary>
public static class Streamer
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        VideoStreaming camera = await client.FindAsync(VideoStreaming.Type);
        using (EventReader<StreamChange> changes = await camera.NotifyStreamStatus.ReadAsync())
        {
            string streamId = Environment.GetEnvironmentVariable("PLAIN") == "1"
                ? await camera.ConnectStreamAsync()
                : await camera.ConnectStreamAsync(
                    encoding: new { codecs = new[] { "video/H264" } }, transport: new { direction = "recvonly" });
            Program.Say("status", (await camera.GetStreamStatusAsync(streamId)).ToString());
            await camera.SuspendStreamAsync(streamId);
            Program.Say("suspended", (await camera.GetStreamStatusAsync(streamId)).ToString());
            await camera.ResumeStreamAsync(streamId);
            await changes.MoveNextAsync();
            string whose = changes.Current.StreamId;
            Program.Say("change", new[] { whose == null || whose == streamId, changes.Current.Timestamp.Year > 2000 });
            Program.Say("playout", await Program.Thrown(
                () => camera.ReportPlayoutAsync(streamId, TimeSpan.FromMilliseconds(80))));
            await camera.DisconnectStreamAsync(streamId);
            Program.Say("unknown", await Program.Thrown(() => camera.GetStreamStatusAsync(streamId)));
        }
        await client.CloseAsync();
    }
}

/// <summary>
/// Watches a stream with a WebRTC library that is elsewhere: offers and candidates are said, and the answer is told.
/// </summary>
public static class Viewer
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        var media = new MediaSession(client, request => new Elsewhere(request));
        var over = new TaskCompletionSource<bool>();
        media.StreamStatusChanged += told =>
        {
            Program.Say("status", told.Status.ToString());
            if (told.Status == StreamStatus.StreamingNotConnected)
            {
                over.TrySetResult(true);
            }
        };
        VideoStreaming camera = await client.FindAsync(VideoStreaming.Type);
        string streamId = await camera.ConnectStreamAsync(encoding: new { codecs = new[] { "video/VP8" } });
        Program.Say("stream", streamId);
        await Elsewhere.Enough.Task;
        await camera.DisconnectStreamAsync(streamId);
        await over.Task;
        media.Dispose();
        await Elsewhere.Disposed.Task;
        await client.CloseAsync();
    }

    private sealed class Elsewhere : IMediaPeer
    {
        internal static readonly TaskCompletionSource<bool> Enough = new TaskCompletionSource<bool>();
        internal static readonly TaskCompletionSource<bool> Disposed = new TaskCompletionSource<bool>();

        internal Elsewhere(MediaPeerRequest request)
        {
            Program.Say("peer", request.PeerId);
        }

        public async Task<string> AnswerAsync(Offer offer)
        {
            Program.Say("offer", new[] { offer.Sdp, offer.Streams[0].StreamId });
            string answer = await Task.Run(() => Console.In.ReadLine());
            Wait();
            return answer.Replace("|", "\r\n");
        }

        public void AddCandidate(Candidate candidate)
        {
            Program.Say("candidate", candidate.CandidateValue);
        }

        public void Dispose()
        {
            Disposed.TrySetResult(true);
        }

        private static async void Wait()
        {
            await Program.Told();
            Enough.TrySetResult(true);
        }
    }
}
