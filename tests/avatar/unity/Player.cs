// Plays a scene with the package's components as Unity would: its methods by their names, frame after frame, on one
// thread, and the sound on another.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Diagnostics;
using System.Reflection;
using System.Threading;
using OpenRoIS.Link;
using OpenRoIS.Link.Unity;
using UnityEngine;
using UnityEngine.Rendering;

public static class Player
{
    private const BindingFlags Own = BindingFlags.Instance | BindingFlags.NonPublic;
    private const int Width = 64;
    private const int Height = 36;
    private const int FrameMs = 20;

    private static readonly List<string> Playing = new List<string>();

    public static int Main(string[] arguments)
    {
        int main = Thread.CurrentThread.ManagedThreadId;
        OpenRoISLink link = new OpenRoISLink
        {
            Address = arguments.Length > 0 ? arguments[0] : "",
            Source = new Camera(),
            Width = Width,
            Height = Height,
            PicturesPerSecond = 50,
            Reactions = new[] { "wave" },
            Walks = true,
            TakesInput = true
        };
        SkinnedMeshRenderer face = new SkinnedMeshRenderer();
        OpenRoISMouth mouth = new OpenRoISMouth { Link = link, Face = face };
        OpenRoISWalker walker = new OpenRoISWalker { Link = link };
        walker.transform.position = new Vector3(0.5f, 1f, 0.25f);
        walker.transform.rotation = Quaternion.Euler(0f, 180f, 0f);
        link.React += (id, reaction) =>
        {
            Say(Thread.CurrentThread.ManagedThreadId == main ? "react " + reaction : "react on another thread");
            Playing.Add(id);
        };
        link.Stop += id => End(link, Status.Abort);
        link.Connected += () => Say("connected");
        link.Disconnected += reason => Playing.Clear();
        link.Look += (x, y) => Say($"look {x} {y}");
        link.Input += input => Say("input");
        link.Quit += () => Say("quit");
        MonoBehaviour[] all = { link, mouth, walker };
        Call(all, "Awake");
        Call(all, "OnEnable");
        Call(all, "Start");
        Vector3[] room = { new Vector3(-2, 0, -2), new Vector3(2, 0, -2), new Vector3(2, 0, 2) };
        link.Floor(room, new IList<Vector3>[] { new[] { room[0], room[2], room[1] } });
        link.Things(new[] { OpenRoISLink.ThingAt("v1", ThingKind.Person, "Visitor", walker.transform) });
        Play(link, all, face);
        Call(all, "OnDisable");
        Call(all, "OnDestroy");
        return 0;
    }

    private static void Play(OpenRoISLink link, MonoBehaviour[] all, SkinnedMeshRenderer face)
    {
        Thread mixer = new Thread(() => Mix(link)) { IsBackground = true };
        mixer.Start();
        AsyncGPUReadback.Pixels = Pixels();
        float widest = 0f;
        Stopwatch time = Stopwatch.StartNew();
        for (int frame = 0; !Application.HasQuit; frame++)
        {
            Time.deltaTime = (float)time.Elapsed.TotalSeconds;
            time.Restart();
            Call(all, "Update");
            Call(all, "LateUpdate");
            foreach (IEnumerator routine in MonoBehaviour.Coroutines)
            {
                routine.MoveNext();
            }
            AsyncGPUReadback.Answer();
            if (frame % 30 == 0)
            {
                End(link, Status.Ok);
            }
            if (face.Weight > widest + 25f)
            {
                widest = face.Weight;
                Say("mouth opens");
            }
            Thread.Sleep(FrameMs);
        }
    }

    /// <summary>A picture whose bottom row is red and whose others are blue.</summary>
    private static byte[] Pixels()
    {
        byte[] pixels = new byte[4 * Width * Height];
        for (int at = 0; at < pixels.Length; at += 4)
        {
            pixels[at] = (byte)(at < 8 * Width ? 0 : 255);
            pixels[at + 2] = (byte)(at < 8 * Width ? 255 : 0);
            pixels[at + 3] = 255;
        }
        return pixels;
    }

    private static void Mix(OpenRoISLink link)
    {
        float[] data = new float[2 * 1024];
        Stopwatch time = Stopwatch.StartNew();
        for (long frames = 0; ; frames += 1024)
        {
            Call(new MonoBehaviour[] { link }, "OnAudioFilterRead", data, 2);
            // What a busy machine has kept from being mixed is mixed at once.
            Thread.Sleep((int)Math.Max(0, frames * 1000 / 44100 - time.ElapsedMilliseconds));
        }
    }

    private static void End(OpenRoISLink link, Status status)
    {
        foreach (string id in Playing)
        {
            link.Completed(id, status);
        }
        Playing.Clear();
    }

    private static void Call(MonoBehaviour[] all, string name, params object[] arguments)
    {
        foreach (MonoBehaviour each in all)
        {
            each.GetType().GetMethod(name, Own)?.Invoke(each, arguments);
        }
    }

    private static void Say(string text)
    {
        Console.WriteLine(text);
        Console.Out.Flush();
    }
}
